"""Stepped sine as time signals, in CSV and as universal file."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import pyuff
from numpy.typing import NDArray
from support.measured_oscillator import FREQUENCY, TOML, displacement, force
from support.universal_file import record

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasuredRun, MeasurementError
from updamp.measurement.readers.time_steps import TimeOptions
from updamp.measurement.readers.uff_file import uff_records
from updamp.measurement.readers.uff_time import read_uff_time

RATE, STEPS = 3600.0, range(8, 34, 5)
UFF = Path(__file__).parents[1] / "data" / "uff"
OPTIONS = 'repeat = 1\nreader = "{}"\nchannels = ["laser"]\noptions = {{ harmonics = [1, 3], settle = "0.1 s" }}\n'


def signals(step: int, noise: float = 1e-6) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(n,) time [s], force [N], reversed velocity [mm/s], with a start that has not settled."""
    rng = np.random.default_rng(step)
    t = np.arange(0, 0.6, 1 / RATE)
    w = 2 * np.pi * FREQUENCY[step]
    x = displacement()[:, step, None] * np.exp(1j * w * np.outer([1, 3], t))
    velocity = np.real(1j * w * np.array([[1], [3]]) * x).sum(axis=0) * (1 + np.exp(-t / 0.004))
    f = np.real(force()[step] * np.exp(1j * w * t))
    return t, f + 0.01 * rng.normal(size=len(t)), -1e3 * (velocity + noise * RATE * rng.normal(size=len(t)))


def check(run: MeasuredRun) -> None:
    expected = displacement()[:, list(STEPS)]
    np.testing.assert_allclose(run.frequency, FREQUENCY[list(STEPS)], atol=2e-4)
    assert run.noise is not None
    assert run.noise.shape == run.response.shape == (1, 2, len(STEPS))
    # The error is a few of the stated deviations, which are small against the signal.
    turned = run.response[0] / (run.force / np.abs(run.force)) ** np.array([[1], [3]])
    reference = expected / np.exp(1j * np.array([[1], [3]]) * np.angle(force()[list(STEPS)]))
    assert np.all(np.abs(turned - reference) < 5 * run.noise[0] + 1e-4 * np.abs(reference))
    assert np.all(run.noise[0, 0] < 0.02 * np.abs(expected[0]))
    assert np.all(run.noise[0, 0] > 1e-5 * np.abs(expected[0]))


def test_csv(tmp_path: Path) -> None:
    lines = ["time_s,frequency_Hz,force,laser,trigger"]
    for step in STEPS:
        lines += [f"{t:.9g},{FREQUENCY[step]:.9g},{f:.9g},{v:.9g},1" for t, f, v in zip(*signals(step), strict=True)]
    (tmp_path / "data.csv").write_text("\n".join(lines) + "\n")
    path = tmp_path / "measurement.toml"
    path.write_text(TOML.replace('amplitude = "rms"', 'amplitude = "peak"') + OPTIONS.format("time_csv"))
    measurement = load_measurement(path)
    check(measurement.runs[0])
    assert any("least squares" in text for text in measurement.assumptions)
    assert any("trigger" in text for text in measurement.assumptions)


@pytest.mark.parametrize("name", ["laser", "Prüfling 1"])
def test_csv_below_a_preamble_and_above_a_row_of_units(tmp_path: Path, name: str) -> None:
    """As a logger writes it, in Latin-1 with tabs: the very harmonics of the plain file; units of another kind of time
    or frequency are refused."""
    rows = [
        "\t".join(f"{x:.9g}" for x in (t, FREQUENCY[step], f, v))
        for step in STEPS
        for t, f, v in zip(*signals(step), strict=True)
    ]
    toml = TOML.replace('amplitude = "rms"', 'amplitude = "peak"').replace(
        "[channels.laser]", f'[channels.laser]\nlabel = "{name}"'
    )
    options = OPTIONS.format("time_csv").replace("settle", r'delimiter = "\t", settle')
    path = tmp_path / "measurement.toml"
    path.write_text(toml + options, encoding="utf-8")
    header = f"time_s\tfrequency_Hz\tforce\t{name}"
    runs = []
    for above, below in (([], []), (["Aufzeichnung: Köln, 3.5.2024", "Rate\t3600"], ["s\tHz\tN\t[mm/s]"])):
        (tmp_path / "data.csv").write_bytes("\r\n".join([*above, header, *below, *rows, ""]).encode("latin-1"))
        runs += load_measurement(path).runs
    np.testing.assert_array_equal(runs[1].response, runs[0].response)
    for units, words in (
        ("ms\tHz\tN\tmm/s", "column 'time_s': its row of units says ms, it is read in s"),
        ("s\tkHz\tN\tmm/s", "column 'frequency_Hz': its row of units says kHz, it is read in Hz"),
        ("s\tHz\tN\tm/s", "channel 'laser': the file says m/s"),
    ):
        (tmp_path / "data.csv").write_bytes("\r\n".join([header, units, *rows, ""]).encode("latin-1"))
        with pytest.raises(MeasurementError, match=words):
            load_measurement(path)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (
            "",
            r"no column 'frequency_Hz', that of the commanded frequency .*`step` names this column; `frequency` is",
        ),
        ('step = "f_sat", ', r"no column 'f_sat', .*did you mean f_set"),
        ('frequency = "f_set", ', r'frequency = "f_set": is a value, .* is named by step = "f_set"'),
    ],
)
def test_the_column_of_the_commanded_frequency_is_missing(tmp_path: Path, option: str, words: str) -> None:
    """The message tells the two keys apart: `step` is a column, `frequency` a value."""
    (tmp_path / "data.csv").write_text("time_s,f_set,force,laser\n0,430,1,1\n")
    path = tmp_path / "measurement.toml"
    options = OPTIONS.format("time_csv").replace("harmonics", f"{option}harmonics")
    path.write_text(TOML.replace('"rms"', '"peak"') + options)
    with pytest.raises(MeasurementError, match=words):
        load_measurement(path)


def test_time_that_restarts_parts_the_steps_at_a_turning_point(tmp_path: Path) -> None:
    lines = ["time_s,frequency_Hz,force,laser"]
    for place, step in enumerate((8, 13, 18, 18, 13, 8)):
        t, f, v = signals(step)
        f = f + 0.1 * np.random.default_rng(place).normal(size=len(t))  # the two fits at the turn differ a little
        lines += [f"{a},{FREQUENCY[step]},{b},{c}" for a, b, c in zip(t, f, v, strict=True)]
    (tmp_path / "data.csv").write_text("\n".join(lines) + "\n")
    toml = TOML.replace('amplitude = "rms"', 'amplitude = "peak"') + OPTIONS.format("time_csv")
    path = tmp_path / "measurement.toml"
    for way, order in (("up", [8, 13, 18]), ("down", [18, 13, 8])):
        path.write_text(toml.replace('sweep = "up"', f'sweep = "{way}"'))
        np.testing.assert_allclose(load_measurement(path).runs[0].frequency, FREQUENCY[order], atol=2e-3)


@pytest.mark.parametrize(
    ("settle", "words"),
    [
        ("2 s", r"step of 428.* Hz: settle = 2 s is all of the step, which lasts 0\.5997 s; shorten settle"),
        ("0.59 s", r"8 or more are wanted \(settle = 0\.59 s of 0\.5997 s is cut off before\)"),
    ],
)
def test_nothing_is_left_after_settling(tmp_path: Path, settle: str, words: str) -> None:
    lines = [
        "time_s,frequency_Hz,force,laser",
        *(f"{t},{FREQUENCY[8]},{f},{v}" for t, f, v in zip(*signals(8), strict=True)),
    ]
    (tmp_path / "data.csv").write_text("\n".join(lines) + "\n")
    path = tmp_path / "measurement.toml"
    path.write_text(TOML.replace('"rms"', '"peak"') + OPTIONS.format("time_csv").replace("0.1 s", settle))
    with pytest.raises(MeasurementError, match=words):
        load_measurement(path)


def write_time_uff(path: Path, second: float = 1, time: str = "s", hertz: float = 1, frequency: str = "Hz") -> None:
    file = pyuff.UFF(str(path))
    for step in STEPS:
        t, f, v = signals(step)
        for name, values, kind, unit in (("force", f, 13, "N"), ("laser", v, 11, "mm/s")):
            fields = {
                "type": 58, "binary": 1, "func_type": 1, "id1": name, "rsp_node": 1, "rsp_dir": 1, "ref_node": 0,
                "ref_dir": 0, "abscissa_spacing": 0, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": kind,
                "ordinate_axis_units_lab": unit, "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 18,
                "z_axis_value": FREQUENCY[step] * hertz, "data": values, "x": t * second,
                "abscissa_axis_units_lab": time, "z_axis_axis_units_lab": frequency,
            }  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResourceWarning)
                file.write_sets([fields], mode="add")


def test_universal_file(tmp_path: Path) -> None:
    write_time_uff(tmp_path / "data.uff")
    path = tmp_path / "measurement.toml"
    toml = TOML.replace('amplitude = "rms"', 'amplitude = "peak"').replace("data.csv", "data.uff")
    path.write_text(toml + OPTIONS.format("uff_time"))
    check(load_measurement(path).runs[0])
    with (tmp_path / "data.uff").open("a") as file:
        file.write(record(np.ones(41), function=6, first="laser"))
    measurement = load_measurement(path)
    check(measurement.runs[0])
    assert "data.uff: records 'laser' that are no time signals are not used" in measurement.assumptions


def test_milliseconds_and_commanded_kilohertz_of_a_universal_file(tmp_path: Path) -> None:
    write_time_uff(tmp_path / "data.uff", 1e3, "ms", 1e-3, "kHz")
    path = tmp_path / "measurement.toml"
    toml = TOML.replace('amplitude = "rms"', 'amplitude = "peak"').replace("data.csv", "data.uff")
    path.write_text(toml + OPTIONS.format("uff_time"))
    check(load_measurement(path).runs[0])
    path.write_text(toml)
    with pytest.raises(MeasurementError, match='holds time signals; read them with reader = "uff_time"'):
        load_measurement(path)


def test_samples_of_pyuff_text_and_binary_are_the_same_signal() -> None:
    (text,), (binary,) = uff_records(UFF / "Sample_UFF58_ascii.uff"), uff_records(UFF / "Sample_UFF58b_bin.uff")
    assert len(text["data"]) == 79292
    np.testing.assert_allclose(text["data"], binary["data"], rtol=1e-5, atol=1e-9)


def test_sample_of_pyuff_is_fitted_only_with_a_frequency_it_has() -> None:
    path = UFF / "Sample_UFF58b_bin.uff"
    with pytest.raises(MeasurementError, match="does not state its frequency"):
        read_uff_time(path, ("Mic 01",), TimeOptions())
    with pytest.raises(MeasurementError, match=r"not at 430 Hz"):
        read_uff_time(path, ("Mic 01",), TimeOptions.model_validate({"frequency": "430 Hz"}))
    with pytest.raises(MeasurementError, match="no record 'force', the force; there are Mic 01"):
        read_uff_time(path, ("force",), TimeOptions())


@pytest.mark.parametrize("reader", ["time_csv", "uff_time"])
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("exp(+iwt)", "exp(-iwt)", 'time_convention = "exp(-iwt)"'),
        ('"mm/s"', '"mm/s"\nphase_of = "displacement"', 'channels.laser.phase_of = "displacement"'),
        ('"peak"\n\n[channels.acc', '"rms"\n\n[channels.acc', 'channels.laser.amplitude = "rms"'),
        ('"peak"\n\n[channels.las', '"peak_to_peak"\n\n[channels.las', 'channels.force.amplitude = "peak_to_peak"'),
    ],
)
def test_what_holds_for_spectra_has_no_meaning_for_samples(
    tmp_path: Path, reader: str, old: str, new: str, words: str
) -> None:
    toml = TOML.replace('"rms"', '"peak"')
    assert old in toml
    (tmp_path / "data.csv").write_text("time_s,frequency_Hz,force,laser\n0,430,1,1\n")
    path = tmp_path / "measurement.toml"
    path.write_text(toml.replace(old, new) + OPTIONS.format(reader))
    with pytest.raises(MeasurementError) as error:
        load_measurement(path)
    for word in ("data.csv", "run 'B 17 N'", words, f"{reader} reads time signals", ": "):
        assert word in str(error.value), str(error.value)
