"""Shapes of several modes, as identified in a test: near a node a small error of one is a large part of a reading."""

from dataclasses import replace

import numpy as np
import pytest
from support import two_modes as arm
from support.two_modes import swept_arm, two_modes

from updamp.comparison.compare import compare
from updamp.comparison.fit.identified_shapes import with_shapes
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.fit.shape_error import ShapeError
from updamp.measurement.measurement import Measurement

NEAR_NODE = 0.03  # of the second mode at the tip, 0.9 at the drive


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> Measurement:
    """Both modes at 1 N with 0.3 % of noise, the tip near a node of the second"""
    monkeypatch.setitem(arm.MODES, "second", (97.0, 0.005, 0.9, NEAR_NODE))
    sound, rng = swept_arm(modes=("first", "second")), np.random.default_rng(4)
    runs = []
    for run in sound.runs:
        noise = rng.standard_normal((2, *run.response.shape))
        runs.append(replace(run, response=run.response * np.exp(0.003 * (noise[0] + 1j * noise[1]))))
    return replace(sound, runs=tuple(runs), repeatability=0.003)


@pytest.mark.parametrize("factor", [1.08, 1.3, 0.7])
def test_an_entry_near_a_node_that_is_a_little_off_is_no_misfit(measured, factor) -> None:
    """By a fourth of a hundredth of the mode's largest, and a hundredth: "the curves differ in shape", and a diagnosis
    identified a shaker's mass that was not there."""
    found, fitted = compare(two_modes(tip={"second": factor * NEAR_NODE}), measured)
    assert found.findings == ()
    (offsets,) = fitted.compared.offsets.values()
    error = offsets.shape["second", "arm.tip.x", 1]
    assert error == pytest.approx((1 - factor) * NEAR_NODE / 0.9, abs=6e-4)


def test_one_that_is_off_by_a_tenth_of_the_largest_is(measured) -> None:
    found, _ = compare(two_modes(tip={"second": NEAR_NODE + 0.09}), measured)
    assert found.findings
    assert not found.adequate


def test_what_an_error_does_is_what_the_modal_sum_has_of_it(measured) -> None:
    model, true = two_modes(tip={"second": 0.04}), two_modes(tip={"second": NEAR_NODE})
    plan = with_shapes(plan_of(measured), model, calibrated=True)
    (run,) = (o for o in plan.observations if o.run.startswith("second"))
    row, drive = (model.components.row(point) for point in (arm.TIP, arm.DRIVE))
    sizes = [
        np.array([one.components.receptance(2 * np.pi * f, [row], [drive])[0, 0] for f in run.frequency])
        for one in (true, model)
    ]
    exact = replace(run, observed=np.column_stack([run.observed[:, :3], np.log(abs(sizes[0])), np.angle(sizes[0])]))
    (_, shape) = with_shapes(replace(plan, observations=(exact,)), model, calibrated=True).observations[0].shapes
    moved = np.log(sizes[0] / sizes[1])
    error = (NEAR_NODE - 0.04) / 0.9
    np.testing.assert_allclose(shape.moves(error), np.stack([moved.real, moved.imag], axis=1), atol=1e-12)


def test_slopes_are_those_of_differences() -> None:
    shape, h = ShapeError(-0.05, np.array([0.7 + 0.2j, 1.0, 0.4 - 0.6j])), 1e-7
    for error in (0.0, 0.01, -0.03):
        differences = (shape.moves(error + h) - shape.moves(error - h)) / (2 * h)
        np.testing.assert_allclose(shape.slopes(error), differences, rtol=1e-6)


def test_a_single_mode_has_the_sensors_gains_alone() -> None:
    plan = plan_of(swept_arm())
    one = replace(two_modes(), modes=("first",))
    assert with_shapes(plan, one, calibrated=True) is plan
