"""Records of universal files beside the wanted ones, their names, units and legal text of other programs."""

from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import FREQUENCY, TOML, displacement, recorded
from support.universal_file import ACCELERATION, UFF_TOML, measured, ratios, record, spectra, units

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.measurement.readers.uff import write_uff58


def load(folder: Path, content: str | bytes, toml: str = UFF_TOML) -> Measurement:
    (folder / "data.uff").write_bytes(content if isinstance(content, bytes) else content.encode())
    (folder / "measurement.toml").write_text(toml)
    return load_measurement(folder / "measurement.toml")


def refused(folder: Path, content: str | bytes, toml: str = UFF_TOML) -> str:
    with pytest.raises(MeasurementError) as error:
        load(folder, content, toml)
    return str(error.value)


def assert_is_the_oscillator(measurement: Measurement) -> None:
    run = measurement.runs[0]
    np.testing.assert_allclose(run.frequency, FREQUENCY, rtol=5e-6)
    for name in ("laser", "accelerometer"):
        np.testing.assert_allclose(run.amplitude(name), displacement()[0], rtol=5e-5)


def test_records_that_are_no_amplitudes_are_skipped_and_said(tmp_path: Path) -> None:
    time = np.arange(500) / 1000.0
    coherence = record(np.ones(41), function=6, response=(2, 1), ordinate=(0, "NONE"))
    signal = record(np.sin(time), time, function=1, response=(2, 1), ordinate=ACCELERATION, abscissa=(17, "s"))
    for more, name in ((coherence, "coherence"), (signal, "time response")):
        measurement = load(tmp_path, spectra() + more)
        assert_is_the_oscillator(measurement)
        assert any("'2+X' is not used: it is of function type" in a and name in a for a in measurement.assumptions)


def test_where_nothing_else_is_there_the_reason_is_the_error(tmp_path: Path) -> None:
    lines = spectra().replace("   12         0    0", "    2         0    0", 1)
    message = refused(tmp_path, lines)
    assert "the force, channel 'force' cannot be read" in message
    assert "auto spectrum" in message


def test_version_numbers_that_count_the_records(tmp_path: Path) -> None:
    data = measured()
    parts = [
        record(data["force"], version=1),
        record(data["acceleration"], version=2, response=(2, 1), ordinate=ACCELERATION),
        record(data["velocity"], version=3, response=(3, 1), ordinate=(11, "mm/s")),
    ]
    measurement = load(tmp_path, "".join(parts))
    assert_is_the_oscillator(measurement)
    assert any("version numbers 1, 2, 3" in a for a in measurement.assumptions)
    assert [r.repeat for r in load(tmp_path, spectra(version=1) + spectra(version=2)).runs] == [1, 2]
    message = refused(tmp_path, "".join(parts) + record(data["force"], version=4))
    assert "'3+X' has the version number 3, not 1" in message


def test_records_without_a_first_line_are_named_by_node_and_direction(tmp_path: Path) -> None:
    message = refused(tmp_path, spectra(), UFF_TOML.replace('"2+X"', '"accelerometer 1"'))
    assert "there are 2+X" in message
    other = record(measured()["force"], FREQUENCY + 1) + ratios()
    assert "records '1+X' and '3+X'" in refused(tmp_path, other)
    same = refused(tmp_path, spectra(first="Test 12"), UFF_TOML.replace('"1+X"', '"a"').replace('"2+X"', '"b"'))
    assert "1+X, 2+X" in same
    write_uff58(tmp_path / "data.uff", [recorded()])  # two harmonics of the laser have one first line
    harmonics = refused(tmp_path, (tmp_path / "data.uff").read_bytes(), TOML.replace("data.csv", "data.uff").replace(
        "[channels.laser]", '[channels.laser]\nlabel = "tip"'))  # fmt: skip
    assert "there are laser" in harmonics


@pytest.mark.parametrize(
    ("unit", "factor", "kind"), [("kHz", 1e-3, 18), ("rad/s", 2 * np.pi, 18), ("rad/s", 2 * np.pi, 0), ("HZ", 1, 18)]
)
def test_frequencies_in_other_units(tmp_path: Path, unit: str, factor: float, kind: int) -> None:
    assert_is_the_oscillator(load(tmp_path, spectra(x=FREQUENCY * factor, abscissa=(kind, unit))))


def test_a_unit_of_frequency_that_is_not_understood_is_named(tmp_path: Path) -> None:
    message = refused(tmp_path, spectra(abscissa=(18, "furlong")))
    assert 'unit of its abscissa, "furlong", is not understood; write Hz, kHz, rad/s or NONE' in message


def test_units_of_data_set_164_hold_where_a_record_has_none(tmp_path: Path) -> None:
    data = measured()
    force_, velocity = record(data["force"]), record(data["velocity"], response=(3, 1), ordinate=(11, "mm/s"))
    millimetres = record(data["acceleration"] * 1e3, response=(2, 1), ordinate=(12, "NONE"))
    content = units(1e3, 1.0) + force_ + millimetres + velocity
    message = refused(tmp_path, content)
    assert 'the file says mm/s^2, measurement.toml unit = "m/s^2"' in message
    assert "data set 164" in message
    measurement = load(tmp_path, content, UFF_TOML.replace('unit = "m/s^2"', 'unit = "mm/s^2"'))
    assert_is_the_oscillator(measurement)
    assert any("'2+X' has no unit label; data set 164 says mm/s^2" in a for a in measurement.assumptions)
    pounds = ratios(below="NONE", scale=4.4482216152605)
    assert_is_the_oscillator(load(tmp_path, units(1.0, 0.22480894) + force_ + pounds))


def padded(text: str) -> str:
    return "".join(f"{line:<80}\n" for line in text.splitlines())


EVEN = np.linspace(428, 432, 41)


@pytest.mark.parametrize(
    "write",
    [
        padded,
        lambda text: padded(text).replace("\n", "\r\n"),
        lambda text: text.replace("    -1\n", "    -1   \n"),
        lambda text: "\n".join(line.replace("E+", "D+").replace("E-", "D-") for line in text.split("\n")),
        lambda text: text.replace("    -1\n    58", "\n    -1\n    58"),
    ],
)
@pytest.mark.parametrize("even", [False, True])
def test_legal_text_of_other_programs(tmp_path: Path, write: object, even: bool) -> None:
    assert callable(write)
    plain = spectra(x=EVEN, even=even)
    expected = load(tmp_path, plain).runs[0]
    found = load(tmp_path, write(plain).encode()).runs[0]
    np.testing.assert_array_equal(found.response, expected.response)
    np.testing.assert_array_equal(found.frequency, expected.frequency)
    assert len(found) == 41


def test_binary_data_are_not_touched(tmp_path: Path) -> None:
    """Numbers that hold the bytes of D, blanks and line ends, between delimiters with blanks."""
    sweep = recorded()
    sweep.channels["laser"].amplitude[1, 3:6] = np.frombuffer(b"D  \n \n@@" * 3, dtype="<f8")
    path = tmp_path / "data.uff"
    write_uff58(path, [sweep])
    spaced = path.read_bytes().replace(b"    -1\n", b"    -1  \n")
    toml = TOML.replace("data.csv", "data.uff")
    expected = load(tmp_path, path.read_bytes(), toml).runs[0]
    assert spaced != path.read_bytes()
    np.testing.assert_array_equal(load(tmp_path, spaced, toml).runs[0].response, expected.response)


def test_six_digits_of_even_spacing_are_said(tmp_path: Path) -> None:
    for text in (spectra(), spectra(x=EVEN, even=True)):
        assert any("known to six digits only" in a and "uneven spacing" in a for a in load(tmp_path, text).assumptions)
    path = tmp_path / "data.uff"
    write_uff58(path, [recorded()])
    toml = TOML.replace("data.csv", "data.uff")
    assert not any("six digits" in a for a in load(tmp_path, path.read_bytes(), toml).assumptions)


@pytest.mark.parametrize("unit", ["m/s2", "m/s²", "(m/s^2)", "M/S^2", "m s-2", "m/s**2"])
def test_usual_spellings_of_a_unit(tmp_path: Path, unit: str) -> None:
    measurement = load(tmp_path, spectra().replace("m/s^2", unit))
    assert_is_the_oscillator(measurement)
    assert not any("not understood" in a for a in measurement.assumptions)
    assert 'measurement.toml unit = "mm/s^2"' in refused(
        tmp_path, spectra().replace("m/s^2", unit), UFF_TOML.replace('"m/s^2"', '"mm/s^2"')
    )


@pytest.mark.parametrize(
    ("unit", "quantity"), [("mm/s", "velocity"), ("um", "displacement"), ("N", "force"), ("mV", "voltage")]
)
def test_the_unit_of_another_quantity_is_refused(tmp_path: Path, unit: str, quantity: str) -> None:
    message = refused(tmp_path, spectra().replace("m/s^2", unit))
    words = (f"the file says {unit}, the unit of a {quantity}", 'quantity = "acceleration"', "'B 17 N'", "data.uff")
    for word in words:
        assert word in message, message


def test_gravity_by_its_usual_names_and_a_label_that_says_nothing(tmp_path: Path) -> None:
    for unit in ("g", "G", "gn", "EU"):
        measurement = load(tmp_path, spectra().replace("m/s^2", unit), UFF_TOML.replace('"m/s^2"', '"g_0"'))
        said = any("the file's unit 'EU' is not understood; g_0 is taken" in a for a in measurement.assumptions)
        assert said == (unit == "EU")


def test_amplitudes_alone_are_sent_to_csv(tmp_path: Path) -> None:
    data = measured()
    real = record(np.abs(data["acceleration"]), response=(2, 1), ordinate=ACCELERATION)
    velocity = record(data["velocity"], response=(3, 1), ordinate=(11, "mm/s"))
    message = refused(tmp_path, record(data["force"]) + real + velocity)
    assert 'write amplitudes alone as CSV, reader = "csv_columns", with phase = "none"' in message
