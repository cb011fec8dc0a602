"""One angle by which all measured responses lag: told by itself, and calibration left alone by it."""

from dataclasses import replace

import numpy as np
import pytest
from support.held_beam import held_beam, of_beam

from updamp.comparison.comparison import Comparison
from updamp.measurement.measurement import Measurement

SOUND = held_beam((80.40,) * 3, (0.003,) * 3)
# Resonances and losses that a linear model does not follow.
FAILING = held_beam((80.40, 80.15, 80.45), (0.0030, 0.0060, 0.0135))


def lagging(measurement: Measurement, *degrees: float) -> Measurement:
    """By one angle a run, or one for all."""
    angles = np.radians(degrees if len(degrees) > 1 else degrees * len(measurement.runs))
    runs = zip(measurement.runs, angles, strict=True)
    return replace(
        measurement, runs=tuple(replace(run, response=run.response * np.exp(-1j * angle)) for run, angle in runs)
    )


def factors(comparison: Comparison) -> dict[str, float]:
    return {one.name: one.after for one in comparison.calibration}


@pytest.fixture(scope="module")
def sound() -> Comparison:
    return of_beam(SOUND)


@pytest.mark.parametrize("degrees", [5.0, pytest.param(-20.0, marks=pytest.mark.long)])
def test_an_angle_is_told_and_nothing_else(degrees: float, sound: Comparison) -> None:
    told = of_beam(lagging(SOUND, degrees))
    (finding,) = told.findings
    assert (finding.quantity, finding.mode, finding.level) == ("phase", "", None)
    assert np.degrees(finding.relative) == pytest.approx(degrees, abs=0.1)
    side = "lag" if degrees > 0 else "lead"
    assert f"{side} the model's by {abs(degrees):.1f} degrees in all runs" in finding.text
    # in place of a stiffness and losses that make up for it
    assert factors(told) == pytest.approx(factors(sound), rel=3e-3)
    assert told.chi2_after == pytest.approx(sound.chi2_after, rel=0.05)


def test_nothing_is_told_of_phases_that_agree(sound: Comparison) -> None:
    assert sound.findings == ()


@pytest.mark.long
def test_a_model_that_fails_otherwise_fails_alike_with_an_angle_on_top() -> None:
    without, told, leading = (of_beam(lagging(FAILING, degrees)) for degrees in (0.0, 5.0, -5.0))
    assert [f.quantity for f in told.findings] == ["phase", *(f.quantity for f in without.findings)]
    assert np.degrees(told.findings[0].relative) == pytest.approx(5, abs=0.5)
    # the same whichever angle it is; without one it is another fit, of a parameter less: as well as it knows itself
    assert factors(told) == pytest.approx(factors(leading), rel=1e-3)
    for one, other in zip(told.calibration, without.calibration, strict=True):
        deviation = np.log(other.upper / other.lower) / (2 * 1.96)
        assert np.log(one.after) == pytest.approx(np.log(other.after), abs=0.5 * deviation), one.name


def test_an_angle_that_grows_with_the_level_is_no_lag() -> None:
    """As microslip turns the phase at the resonance."""
    told = of_beam(lagging(SOUND, 1.0, 4.0, 9.0))
    assert "phase" not in {f.quantity for f in told.findings}


def test_without_phases_no_angle_is_read() -> None:
    runs = tuple(replace(run, response=np.abs(run.response), without_phase=("a",)) for run in SOUND.runs)
    assert of_beam(replace(SOUND, runs=runs)).findings == ()


@pytest.mark.long
def test_a_force_of_the_wrong_sign_is_no_lag() -> None:
    assert "phase" not in {f.quantity for f in of_beam(lagging(SOUND, 180.0)).findings}


def test_one_level_alone_tells_no_lag() -> None:
    """It agrees with itself, and what leans turns the phase at its top as well."""
    one = lagging(replace(SOUND, runs=SOUND.runs[:1]), 5.0)
    assert "phase" not in {f.quantity for f in of_beam(one).findings}
