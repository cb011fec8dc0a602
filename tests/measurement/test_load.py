"""A measurement comes out as displacement, peak, SI, whatever it was recorded as."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from support.measured_oscillator import FREQUENCY, TOML, displacement, force, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.measurement.readers.hdf5 import write_hdf5
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedSweep

Write = Callable[[Path, Sequence[RecordedSweep]], None]


def written(folder: Path, toml: str = TOML, sweeps: Sequence[RecordedSweep] | None = None) -> Path:
    write_long_csv(folder / "data.csv", [recorded()] if sweeps is None else sweeps)
    path = folder / "measurement.toml"
    path.write_text(toml)
    return path


def assert_is_the_oscillator(measurement: Measurement, rtol: float = 1e-12) -> None:
    assert measurement.runs
    for run in measurement.runs:
        np.testing.assert_allclose(run.frequency, FREQUENCY, rtol=min(rtol, 1e-5))
        np.testing.assert_allclose(run.force, force(run.repeat), rtol=rtol)
        assert run.channels == ("laser", "accelerometer")
        assert run.harmonics == (1, 3)
        for row in run.response:
            np.testing.assert_allclose(row, displacement(run.repeat), rtol=rtol)


def write_text_uff(path: Path, sweeps: Sequence[RecordedSweep]) -> None:
    write_uff58(path, sweeps, binary=False)


@pytest.mark.parametrize(
    ("name", "write", "rtol"),
    [
        ("data.csv", write_long_csv, 1e-12),
        ("data.uff", write_uff58, 1e-12),
        ("text.unv", write_text_uff, 1e-5),  # six digits of frequency
        ("data.h5", write_hdf5, 1e-12),
    ],
)
def test_every_format_gives_the_same(tmp_path: Path, name: str, write: Write, rtol: float) -> None:
    write(tmp_path / name, [recorded(1), recorded(2), recorded(3), recorded(1, run="other")])
    path = tmp_path / "measurement.toml"
    path.write_text(TOML.replace("data.csv", name))
    measurement = load_measurement(path, ["mass.drive.x", "mass.tip.x"], rig="oscillator")
    assert [run.repeat for run in measurement.runs] == [1, 2, 3]
    assert_is_the_oscillator(measurement, rtol)
    assert measurement.pull == 960
    assert [(c.name, c.point, c.negative) for c in measurement.channels] == [
        ("laser", "mass.tip.x", True),
        ("accelerometer", "mass.drive.x", False),
    ]
    run = measurement.runs[0]
    assert (run.name, run.mode, run.upwards, run.held, run.level) == ("B 17 N", "B", True, "force", 17.0)
    assert measurement.hashes is not None
    assert measurement.hashes[name] == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
    assert set(measurement.hashes) == {name, "measurement.toml"}


def german(folder: Path, spoil: Callable[[str], str] = lambda text: text) -> Path:
    """The long form as a German spreadsheet exports it."""
    write_long_csv(folder / "plain.csv", [recorded(1), recorded(2), recorded(3)])
    text = (folder / "plain.csv").read_text().replace(",", ";").replace(".", ",")
    (folder / "data.csv").write_text(spoil(text))
    path = folder / "measurement.toml"
    path.write_text(f'{TOML}options = {{ delimiter = ";", decimal = "," }}\n')
    return path


def test_decimal_commas_and_semicolons_are_read_where_they_are_stated(tmp_path: Path) -> None:
    assert_is_the_oscillator(load_measurement(german(tmp_path)))


def test_a_point_that_parts_thousands_is_no_decimal_point(tmp_path: Path) -> None:
    path = german(tmp_path, lambda text: text.replace(";428,", ";4.28,", 1))
    with pytest.raises(MeasurementError, match=r'frequency_Hz = "4\.28,.*": not a number; with decimal = "," numbers'):
        load_measurement(path)


def test_a_complete_statement_needs_no_assumption(tmp_path: Path) -> None:
    path = written(tmp_path, sweeps=[recorded(1), recorded(2), recorded(3)])
    assert load_measurement(path).assumptions == ()


def test_what_is_not_stated_is_an_assumption(tmp_path: Path) -> None:
    toml = TOML.replace('amplitude = "peak"\n', "").replace('amplitude = "rms"\n', "")
    toml = toml.replace('time_convention = "exp(+iwt)"\n', "").replace('sweep = "up"\n', "")
    sweep = recorded(None, sweep="")
    aux = {**sweep.channels, "thermocouple": sweep.channels["force"]}
    text = "\n".join(load_measurement(written(tmp_path, toml, [replace(sweep, channels=aux)])).assumptions)
    for words in ("peak values", "exp(+iwt)", "direction", "repeat", "fewer than 3 assemblies", "thermocouple"):
        assert words in text


@pytest.mark.parametrize("cut", [1, 2, 8])
def test_a_file_without_a_last_line_end_may_be_cut_off(tmp_path: Path, cut: int) -> None:
    path = written(tmp_path)
    data = tmp_path / "data.csv"
    data.write_bytes(data.read_bytes()[:-cut])
    (said,) = (text for text in load_measurement(path).assumptions if "line end" in text)
    assert data.read_text().rsplit(",", 1)[1] in said
    data.write_bytes(data.read_bytes() + b"\r\n")
    assert not any("line end" in text for text in load_measurement(path).assumptions)


def test_a_downward_sweep_keeps_its_order(tmp_path: Path) -> None:
    toml = TOML.replace('"up"', '"down"')
    sorted_by_recorder = load_measurement(written(tmp_path, toml, [recorded(sweep="down")]))
    up = recorded(sweep="down")
    turned = {n: replace(c, amplitude=c.amplitude[:, ::-1]) for n, c in up.channels.items()}
    as_measured = load_measurement(written(tmp_path, toml, [replace(up, frequency=FREQUENCY[::-1], channels=turned)]))
    for measurement in (sorted_by_recorder, as_measured):
        run = measurement.runs[0]
        assert not run.upwards
        np.testing.assert_array_equal(run.frequency, FREQUENCY[::-1])
        np.testing.assert_allclose(run.response[0], displacement()[:, ::-1], rtol=1e-12)
    assert any("sorted by the recorder" in text for text in sorted_by_recorder.assumptions)


def test_up_and_down_in_one_file_are_told_apart(tmp_path: Path) -> None:
    down = TOML[TOML.index("[[runs]]") :].replace("B 17 N", "B 17 N down").replace('"up"', '"down"\nrun = "B 17 N"')
    path = written(tmp_path, TOML + down, [recorded(), recorded(sweep="down")])
    assert [run.upwards for run in load_measurement(path).runs] == [True, False]


def test_conventions_that_differ(tmp_path: Path) -> None:
    sweep = recorded()
    conjugated = {n: replace(c, amplitude=np.conj(c.amplitude)) for n, c in sweep.channels.items()}
    path = written(tmp_path, TOML.replace("+iwt", "-iwt"), [replace(sweep, channels=conjugated)])
    np.testing.assert_allclose(load_measurement(path).runs[0].response[0], displacement(), rtol=1e-12)
    doubled = {
        n: replace(c, amplitude=c.amplitude * (8**0.5 if n == "laser" else 1)) for n, c in sweep.channels.items()
    }
    path = written(tmp_path, TOML.replace('"rms"', '"peak_to_peak"'), [replace(sweep, channels=doubled)])
    np.testing.assert_allclose(load_measurement(path).runs[0].response[0], displacement(), rtol=1e-12)


def test_phases_may_be_told_against_a_response(tmp_path: Path) -> None:
    """As by an analyser whose reference is a sensor: it has no phase of its own, force and other sensors have."""
    sweep = recorded()
    turn = np.exp(-1j * np.angle(sweep.channels["laser"].amplitude[0]))
    channels = {
        name: replace(channel, amplitude=channel.amplitude[:1] * turn, harmonics=(1,))
        for name, channel in sweep.channels.items()
    }
    laser = replace(channels["laser"], amplitude=channels["laser"].amplitude.real + 0j)
    path = written(tmp_path, TOML, [replace(sweep, channels={**channels, "laser": laser})])
    (run,) = load_measurement(path).runs
    for channel in run.channels:
        np.testing.assert_allclose(run.receptance(channel), displacement()[0] / force(), rtol=1e-12)


def test_phase_of_another_quantity(tmp_path: Path) -> None:
    sweep = recorded()
    w = 2 * np.pi * FREQUENCY * np.array([[1], [3]])
    mixed = replace(sweep.channels["accelerometer"], amplitude=w**2 * displacement() / 9.80665)
    sweep = replace(sweep, channels={**sweep.channels, "accelerometer": mixed})
    path = written(tmp_path, TOML.replace('"g_0"', '"g_0"\nphase_of = "displacement"'), [sweep])
    assert_is_the_oscillator(load_measurement(path))


def test_frequency_response_functions_are_multiplied_by_the_force(tmp_path: Path) -> None:
    sweep = recorded()
    first = {n: replace(c, amplitude=c.amplitude[:1], harmonics=(1,)) for n, c in sweep.channels.items()}
    raw = first["force"].amplitude
    sorts = {"laser": np.sqrt(2), "accelerometer": 1}  # of its amplitude to the force's: divided are peak by peak
    divided = {
        n: replace(c, amplitude=c.amplitude * sorts[n] / raw, per_force=True) if n in sorts else c
        for n, c in first.items()
    }
    write_uff58(tmp_path / "frf.uff", [replace(sweep, channels=divided)])
    path = tmp_path / "measurement.toml"
    path.write_text(TOML.replace("data.csv", "frf.uff"))
    run = load_measurement(path).runs[0]
    np.testing.assert_allclose(run.response[:, 0], np.array([displacement()[0]] * 2), rtol=1e-12)


def test_noise_becomes_that_of_the_displacement(tmp_path: Path) -> None:
    toml = TOML.replace('"rms"', '"rms"\nnoise = "3 um/s"').replace('"g_0"', '"g_0"\nnoise = "0.001 g_0"')
    noise = load_measurement(written(tmp_path, toml)).runs[0].noise
    w = 2 * np.pi * FREQUENCY * np.array([[1], [3]])
    assert noise is not None
    np.testing.assert_allclose(noise[0], 3e-6 * np.sqrt(2) / w, rtol=1e-12)
    np.testing.assert_allclose(noise[1], 9.80665e-3 / w**2, rtol=1e-12)
    assert load_measurement(written(tmp_path)).runs[0].noise is None


def test_response_held_and_nothing_held(tmp_path: Path) -> None:
    held = 'held = "force"\nlevel = "17 N"'
    a = np.abs(displacement()[0]) * (2 * np.pi * FREQUENCY) ** 2
    response = f'held = "response"\nheld_channel = "accelerometer"\nlevel = "{np.median(a):.6f} m/s^2"'
    run = load_measurement(written(tmp_path, TOML.replace(held, response))).runs[0]
    assert run.held == "response"
    assert run.level == pytest.approx(np.median(a), rel=1e-6)
    run = load_measurement(written(tmp_path, TOML.replace(held, 'held = "nothing"'))).runs[0]
    assert run.level == pytest.approx(np.median(np.abs(force())))


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_matlab(tmp_path: Path, version: str) -> None:
    sweep = recorded()
    data = {name: channel.amplitude for name, channel in sweep.channels.items()}
    data["force"] = np.vstack([data["force"], 0 * data["force"]])
    if version == "5":
        scipy.io.savemat(tmp_path / "data.mat", {"test": {"f": FREQUENCY[:, None], **data}, "note": "made by a test"})
    else:
        kind = np.dtype([("real", float), ("imag", float)])
        with h5py.File(tmp_path / "data.mat", "w", userblock_size=512) as file:
            file["test/f"] = FREQUENCY[None]
            for name, values in data.items():
                file[f"test/{name}"] = np.ascontiguousarray(values.T).view(kind).reshape(values.T.shape)
    toml = TOML.replace("data.csv", "data.mat").replace('level = "17 N"', 'level = "17 N"\nrepeat = 1')
    for name in data:
        toml = toml.replace(f"[channels.{name}]", f'[channels.{name}]\nlabel = "test.{name}"')
    path = tmp_path / "measurement.toml"
    path.write_text(toml + 'options = { frequency = "test.f", frequency_unit = "Hz", harmonics = [1, 3] }')
    assert_is_the_oscillator(load_measurement(path))


@pytest.mark.parametrize("phase", ['phase = { laser = "angle" }\nphase_unit = "deg"', 'imaginary = { laser = "imag" }'])
def test_columns_of_a_spreadsheet(tmp_path: Path, phase: str) -> None:
    laser = recorded().channels["laser"].amplitude[0] / np.exp(1j * np.angle(force()))
    values = laser.real if "imag" in phase else np.abs(laser)
    table = np.column_stack([FREQUENCY, np.abs(force()), values, np.rad2deg(np.angle(laser)), laser.imag])
    lines = [";".join(f"{x:.16g}" for x in row) for row in table]
    (tmp_path / "data.csv").write_text("# exported\nHz;force;laser;angle;imag\n" + "\n".join(lines) + "\n")
    options = (
        'reader = "csv_columns"\nrepeat = 1\nchannels = ["laser"]\n[runs.options]\nfrequency = "Hz"\ndelimiter = ";"\n'
    )
    path = tmp_path / "measurement.toml"
    path.write_text(TOML + options + phase)
    measurement = load_measurement(path)
    run = measurement.runs[0]
    np.testing.assert_allclose(run.receptance("laser"), displacement()[0] / force(), rtol=1e-11)
    assert any("no phase is named for the force, 'force'" in text for text in measurement.assumptions)
