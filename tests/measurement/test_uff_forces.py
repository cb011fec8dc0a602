"""Frequency response functions of universal files become responses by the force that they were divided by."""

from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import displacement, force
from support.universal_file import POUND, UFF_TOML, measured, ratios, record, spectra

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError

NOT_RECORDED = ('unit = "N"', 'unit = "N"\nrecorded = false')


def load(folder: Path, content: str, *changes: tuple[str, str]) -> Measurement:
    toml = UFF_TOML
    for old, new in changes:
        assert old in toml
        toml = toml.replace(old, new, 1)
    (folder / "data.uff").write_text(content)
    (folder / "measurement.toml").write_text(toml)
    return load_measurement(folder / "measurement.toml")


def refused(folder: Path, content: str, *changes: tuple[str, str]) -> str:
    with pytest.raises(MeasurementError) as error:
        load(folder, content, *changes)
    return str(error.value)


def assert_is_the_oscillator(measurement: Measurement) -> None:
    run = measurement.runs[0]
    for name in ("laser", "accelerometer"):
        np.testing.assert_allclose(run.receptance(name), displacement()[0] / force(), rtol=2e-5)


POUNDS = record(measured()["force"] / POUND, ordinate=(13, "lbf"))
NEWTONS = record(measured()["force"])


def test_the_units_of_the_force_and_of_the_divisor_are_each_their_own(tmp_path: Path) -> None:
    in_pounds = ('unit = "N"', 'unit = "lbf"')
    assert_is_the_oscillator(load(tmp_path, POUNDS + ratios(), in_pounds))
    assert_is_the_oscillator(load(tmp_path, NEWTONS + ratios(below="lbf", scale=POUND)))
    assert_is_the_oscillator(load(tmp_path, ratios(below="LBF", scale=POUND), NOT_RECORDED))
    assert_is_the_oscillator(load(tmp_path, ratios(below="kN", scale=1e3), NOT_RECORDED))
    nothing = load(tmp_path, POUNDS + ratios(below="NONE", scale=POUND), in_pounds)
    assert_is_the_oscillator(nothing)
    assert any("divided by is not stated; lbf is taken" in a for a in nothing.assumptions)


def test_the_divisor_behind_a_stroke_in_the_label_of_the_response(tmp_path: Path) -> None:
    stroke = ratios(below="NONE", acceleration=(12, "(m/s^2)/lbf"), scale=POUND)
    measurement = load(tmp_path, NEWTONS + stroke)
    np.testing.assert_allclose(measurement.runs[0].receptance("accelerometer"), displacement()[0] / force(), rtol=2e-5)
    contradiction = ratios(below="N", acceleration=(12, "m/s^2/lbf"))
    assert 'in "m/s^2/lbf" (record 9) but divided by "N" (record 10)' in refused(tmp_path, NEWTONS + contradiction)


def test_a_divisor_that_is_not_understood_is_named(tmp_path: Path) -> None:
    message = refused(tmp_path, NEWTONS + ratios(below="Volt"))
    assert '"Volt" (record 10 of data set 58), is that of a voltage' in message
    assert "kN" in message
    unknown = load(tmp_path, NEWTONS + ratios(below="EU"))  # engineering units, as of the response
    assert any("divided by, 'EU', is not understood; N is taken" in a for a in unknown.assumptions)


def test_a_ratio_is_peak_by_peak(tmp_path: Path) -> None:
    rms = record(measured()["force"] / np.sqrt(2))
    assert_is_the_oscillator(load(tmp_path, rms + ratios(), ('amplitude = "peak"', 'amplitude = "rms"')))


def test_a_reference_towards_minus_turns_the_sign(tmp_path: Path) -> None:
    recorded = load(tmp_path, NEWTONS + ratios((1, -1), scale=-1.0))
    assert_is_the_oscillator(recorded)
    assert any("its reference -X is opposite to the force's +X" in a for a in recorded.assumptions)
    assert_is_the_oscillator(load(tmp_path, ratios((1, -1), scale=-1.0), NOT_RECORDED))
    both = record(-measured()["force"], response=(1, -1)) + ratios((1, -1), scale=-1.0)
    reversed_ = ('direction = "x"\nunit = "N"\nlabel = "1+X"', 'direction = "-x"\nunit = "N"\nlabel = "1-X"')
    assert_is_the_oscillator(load(tmp_path, both, reversed_))


def test_another_axis_of_the_file_is_said(tmp_path: Path) -> None:
    measurement = load(tmp_path, ratios((1, -3)), NOT_RECORDED, ('"1+X"', '"shaker"'))
    assert_is_the_oscillator(measurement)
    assert any("its reference -Z is taken for the force's +X" in a for a in measurement.assumptions)


def test_responses_to_another_force_are_refused(tmp_path: Path) -> None:
    message = refused(tmp_path, NEWTONS + ratios((3, 1)))
    assert "divided by the force at 3+X" in message
    assert "the force is at 1+X; name the force at 3+X, or take functions whose reference is 1+X" in message
    assert "divided by the force at 1+Z" in refused(tmp_path, NEWTONS + ratios((1, 3)))


def test_a_run_of_another_force_does_not_hinder_the_one_that_is_listed(tmp_path: Path) -> None:
    other = record(measured()["force"], response=(3, 1), second="tip") + ratios((3, 1), second="tip")
    listed = record(measured()["force"], second="B 17 N") + ratios(second="B 17 N")
    assert_is_the_oscillator(load(tmp_path, other + listed))


def test_of_several_references_that_of_the_force_is_taken(tmp_path: Path) -> None:
    two = ratios((3, 1), scale=7.0) + ratios((1, 1))
    measurement = load(tmp_path, NEWTONS + two)
    assert_is_the_oscillator(measurement)
    assert any(
        "'2+X' divided by the force at 3+X (reference, record 6) are not used" in a for a in measurement.assumptions
    )
    assert_is_the_oscillator(load(tmp_path, two, NOT_RECORDED))
    message = refused(tmp_path, two, NOT_RECORDED, ('"1+X"', '"shaker"'))
    assert "forces at 3+X and 1+X" in message
    assert 'label = "3+X"' in message
    of_one, of_other = ratios((3, 1)).split("    -1\n    58"), ratios((1, 1)).split("    -1\n    58")
    one_each = "".join(f"    -1\n    58{part}" for part in (of_one[1], of_other[2]))
    assert "forces at 1+X and 3+X" in refused(tmp_path, one_each, NOT_RECORDED, ('"1+X"', '"shaker"'))


def test_spectra_beside_response_functions_are_told_apart_by_nobody(tmp_path: Path) -> None:
    message = refused(tmp_path, spectra() + ratios())
    assert "more than one record of '3+X'" in message
    assert "one is a spectrum, one a frequency response function" in message


def test_the_force_shares_its_node_with_the_response_there(tmp_path: Path) -> None:
    drive, other = ratios().split("    -1\n    58", 2)[1:]
    drive = drive.replace("\nNONE", "\naccelerometer", 1).replace("         2   1 NONE", "         1   1 NONE")
    content = NEWTONS + "".join(f"    -1\n    58{part}" for part in (drive, other))
    assert_is_the_oscillator(load(tmp_path, content, ('label = "2+X"', 'label = "accelerometer"')))


def test_an_uncalibrated_force_divides_in_its_own_unit(tmp_path: Path) -> None:
    volts = ('unit = "N"', 'unit = "V"\nuncalibrated = true\nrecorded = false'), ('level = "17 N"', 'level = "17 V"')
    assert_is_the_oscillator(load(tmp_path, ratios(below="V"), *volts))
    assert 'divided by a force in "N", the force is uncalibrated in "V"' in refused(tmp_path, ratios(), *volts)


def test_a_record_towards_minus_is_turned_whatever_it_is_of(tmp_path: Path) -> None:
    """A response as spectrum and over force, and the force itself, which its functions are divided by too."""
    data = measured()
    velocity = record(data["velocity"], response=(3, 1), ordinate=(11, "mm/s"))
    minus = ('label = "2+X"', 'label = "2-X"')
    towards = {"response": (2, -1), "ordinate": (12, "m/s^2")}
    ratio = record(-data["acceleration"] / data["force"], function=4, reference=(1, 1), below=(13, "N"), **towards)
    for one in (record(-data["acceleration"], **towards), ratio):
        turned = load(tmp_path, NEWTONS + one + velocity, minus)
        assert_is_the_oscillator(turned)
        assert any(
            "channel 'accelerometer': the file's direction -X is opposite to +x" in a for a in turned.assumptions
        )
    stated = load(tmp_path, spectra(), ('direction = "x"\nunit = "mm/s"', 'direction = "-x"\nunit = "mm/s"'))
    assert any("direction +X is taken for the model's -x" in a for a in stated.assumptions)
    force_towards_minus = record(-data["force"], response=(1, -1))
    for responses in (ratios((1, 1)), ratios((1, -1), scale=-1.0)):
        assert_is_the_oscillator(load(tmp_path, force_towards_minus + responses, ('label = "1+X"', 'label = "1-X"')))
