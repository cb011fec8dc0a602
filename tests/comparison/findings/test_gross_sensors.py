"""A sensor that is far off is named, whatever calibration has made of it."""

import numpy as np
import pytest
from support.two_modes import DRIVE, TIP, swept_arm, two_modes

from updamp.comparison.compare import compare
from updamp.comparison.findings.kinds import SensorGain


@pytest.mark.parametrize("gain", [2.0, pytest.param(0.1, marks=pytest.mark.long)])
def test_a_sensor_that_is_far_off_is_named_with_its_size(gain: float) -> None:
    comparison, _ = compare(two_modes(), swept_arm(tip=gain, modes=("first", "second")))
    (sensor,) = [f for f in comparison.findings if f.quantity == SensorGain.quantity]
    # of two sensors one is held against the other, and it is not told which is wrong
    assert sensor.channel in (DRIVE, TIP)
    wanted = 1 / gain if sensor.channel == TIP else gain
    assert 1 + sensor.relative == pytest.approx(wanted, rel=0.03)


@pytest.mark.long
def test_a_shape_that_is_wrong_in_one_mode_is_no_sensor() -> None:
    """Twice the shape in one mode, half of it in the other."""
    model = two_modes(tip={"first": 3.0, "second": -0.55})
    comparison, _ = compare(model, swept_arm(modes=("first", "second")))
    assert not comparison.adequate
    assert not [f for f in comparison.findings if f.quantity == SensorGain.quantity]


def test_exact_data_leave_nothing_to_say() -> None:
    comparison, fit = compare(two_modes(), swept_arm(modes=("first", "second")))
    assert comparison.adequate
    assert np.isfinite(fit.compared.chi2)
