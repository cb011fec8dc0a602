"""Phases in the report: whole curves, beside each other, whichever way they were swept and whatever a sensor's sign."""

from dataclasses import replace

import numpy as np
import pytest
from support.synthetic_comparison import synthetic_comparison

from updamp.comparison.comparison import CurvePair, MeasuredCurve, ModelCurve
from updamp.report.phases import CurvePhases, phases_of, turns, unwrapped_phase


@pytest.fixture(scope="module")
def curves() -> tuple[CurvePair, ...]:
    return synthetic_comparison(sweeps=(True, False)).curves


def turned(curve: CurvePair, degrees: float) -> CurvePair:
    factor = np.exp(1j * np.radians(degrees))
    branches = [replace(b, receptance=b.receptance * factor) for b in (curve.before, curve.after)]
    measured = tuple(replace(m, receptance=m.receptance * factor) for m in curve.measured)
    return replace(curve, measured=measured, before=branches[0], after=branches[1])


def backwards(curve: CurvePair) -> CurvePair:
    """Its points listed from high frequency to low, as a sweep downwards leaves them."""
    measured = tuple(
        MeasuredCurve(m.repeat, m.frequency[::-1], m.receptance[::-1], m.force[::-1]) for m in curve.measured
    )
    branches = [ModelCurve(b.frequency[::-1], b.receptance[::-1], b.visited[::-1]) for b in (curve.before, curve.after)]
    return replace(curve, measured=measured, before=branches[0], after=branches[1])


def whole(phases: CurvePhases) -> bool:
    """None is cut: a resonance is half a turn wide."""
    return all(np.ptp(each) < 190 for each in (*phases.measured, phases.before, phases.after))


@pytest.mark.parametrize("degrees", np.arange(-180.0, 180.0, 30.0))
def test_no_curve_is_cut_and_all_of_a_mode_lie_beside_each_other(curves, degrees):
    found = phases_of([turned(curve, degrees) for curve in curves])
    assert all(whole(each) for each in found)
    for curve, phases in zip(curves, found, strict=True):
        first = next(
            p for c, p in zip(curves, found, strict=True) if (c.mode, c.channel) == (curve.mode, curve.channel)
        )
        for each in (*phases.measured, phases.before, phases.after):
            assert abs(np.median(each) - np.median(first.measured[0])) < 180
        assert -181 <= (phases.measured[0].min() + phases.measured[0].max()) / 2 <= 181


def test_the_order_of_the_points_does_not_matter(curves):
    for one, other in zip(phases_of(curves), phases_of([backwards(c) for c in curves]), strict=True):
        for a, b in zip(one.measured, other.measured, strict=True):
            np.testing.assert_allclose(a, b[::-1], atol=1e-9)
        np.testing.assert_allclose(one.after, other.after[::-1], atol=1e-9)


def test_phases_are_those_of_the_receptance(curves):
    for curve, phases in zip(curves, phases_of(curves), strict=True):
        for values, phase in (
            (curve.after.receptance, phases.after),
            (curve.measured[1].receptance, phases.measured[1]),
        ):
            np.testing.assert_allclose(np.abs(values) * np.exp(1j * np.radians(phase)), values, rtol=1e-9)


def test_a_branch_beyond_resonance_lies_at_the_measured_phases_beyond_it(curves):
    """Part of a branch alone, entirely on one side of its own resonance: cut there, it would be half a turn off."""
    curve = curves[0]
    beyond = np.degrees(np.angle(curve.after.receptance)) < -150
    part = ModelCurve(curve.after.frequency[beyond], curve.after.receptance[beyond], curve.after.visited[beyond])
    found = phases_of([replace(curve, after=part)])[0]
    assert -190 < found.after.min() <= found.after.max() < -140


def test_gaps_are_left_and_unwrapped_across():
    receptance = np.exp(-1j * np.radians([10.0, 120.0, 0.0, 230.0, 300.0]))
    receptance[2] = 0
    receptance[4] = np.nan
    phase = unwrapped_phase(receptance)
    np.testing.assert_allclose(phase[[0, 1, 3]], [-10.0, -120.0, -230.0])
    assert np.isnan(phase[[2, 4]]).all()


def test_curves_without_a_known_value_have_no_phase(curves):
    nothing = replace(curves[0].measured[0], receptance=np.full_like(curves[0].measured[0].receptance, np.nan))
    found = phases_of([replace(curves[0], measured=(nothing,)), curves[0]])
    assert np.isnan(found[0].measured[0]).all()
    assert whole(found[1])
    assert (turns(float("nan")), turns(170.0), turns(190.0), turns(-200.0)) == (0, 0, 360, -360)
