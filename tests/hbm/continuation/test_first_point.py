"""First points where neither the stuck nor the free response is near: along the branch from a small force."""

import numpy as np
import pytest
from support.peers import blades_and_damper_system, one_degree_of_freedom

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.continuation.first_point import ForceRamp, by_force_continuation, first_point
from updamp.hbm.continuation.predictor_corrector import ContinuationOptions, PredictorCorrector
from updamp.hbm.newton.equation import evaluate, linear_solution
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation

DAMPING, CUBIC, W = 0.05, 1.0, 1.6
FOLD = 0.85  # N, about: up to here there is a small response


@pytest.fixture(scope="module")
def hardening():
    """Above its resonance, where the response to a rising force jumps up."""
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([CUBIC])), np.array([[0]]))
    return one_degree_of_freedom(DAMPING, group, (1,), 32)


def amplitudes(force):
    """((1 - w^2 + 3/4 g a^2)^2 + (c w)^2) a^2 = F^2, the one-term harmonic balance of Duffing's oscillator"""
    off, loss = 1 - W**2, (DAMPING * W) ** 2
    in_square = [9 / 16 * CUBIC**2, 3 / 2 * CUBIC * off, off**2 + loss, -(force**2)]
    roots = np.roots(in_square)
    return np.sqrt(np.sort(roots[np.abs(roots.imag) < 1e-9].real))


@pytest.mark.parametrize("force", [0.2, 0.7, 1.0, 2.0])
def test_the_branch_from_a_small_force_is_followed_through_its_folds(hardening, force):
    """Below the fold the small response, the first that is met; beyond it the one that is left, two folds later."""
    system = hardening
    solution = by_force_continuation(system, Excitation(system.free.row("mass"), force), W, ContinuationOptions())
    assert solution.converged
    found = np.linalg.norm(solution.x)
    assert found == pytest.approx(amplitudes(force)[0], rel=1e-7)
    if force > FOLD:
        assert found > 1.0


def test_both_ways_find_the_same_where_there_is_one_solution():
    system = blades_and_damper_system(JenkinsBox(2))
    excitation, w = Excitation(system.free.row("excitation"), 10.0), 2 * np.pi * 232.0
    direct, along = (
        first_point(system, excitation, w),
        by_force_continuation(system, excitation, w, ContinuationOptions()),
    )
    np.testing.assert_allclose(along.x, direct.x, atol=1e-6 * np.abs(direct.x).max())


def test_where_the_branch_stops_the_frequency_is_said(hardening, monkeypatch):
    """Not the logarithm of the force, which is what varies along it."""
    next_points = PredictorCorrector.next_points

    def stops(stepper, traced, step):
        if np.exp(traced.last.w) > 0.5:
            raise BranchStoppedError(traced.last.frequency, 1e-3, Status.STALLED)
        return next_points(stepper, traced, step)

    monkeypatch.setattr(PredictorCorrector, "next_points", stops)
    with pytest.raises(BranchStoppedError, match="stalled") as stop:
        by_force_continuation(hardening, Excitation(hardening.free.row("mass"), 0.7), W, ContinuationOptions())
    assert stop.value.frequency == pytest.approx(W / 2 / np.pi)


def test_derivative_in_the_force_against_differences():
    system = blades_and_damper_system(JenkinsBox(2))
    w, level = 2 * np.pi * 232.0, np.log(10.0)
    ramp = ForceRamp(system.free.row("excitation"), w)
    x = linear_solution(system, w, ramp.at(level)[1])
    exact = evaluate(system, ramp, x, level).frequency_derivative(ramp)
    ahead, behind = (evaluate(system, ramp, x, level + step).residual for step in (1e-5, -1e-5))
    np.testing.assert_allclose((ahead - behind) / 2e-5, exact, atol=1e-8 * np.abs(exact).max())
    assert np.isfinite(evaluate(system, ramp, x, 1e6).residual).all(), "Newton's method may ask for any force"


def test_a_drift_of_the_mean_position_does_not_hide_the_vibration():
    """Neither in the metric nor in the tolerance, however far the damper has drifted."""
    system = blades_and_damper_system(JenkinsBox(2))
    excitation, w = Excitation(system.free.row("excitation"), 1.0), 2 * np.pi * 232.0
    x = linear_solution(system, w, excitation)
    drifted = x.copy()
    drifted[:, 0] += 1e6 * np.abs(x).max()
    change = (0.1 * x, 0.0)
    lengths = [Metric.at(y, system.harmonics, 1.0).length(change) for y in (x, drifted)]
    assert lengths == pytest.approx([0.1, 0.1], rel=1e-9)
    far = Metric.at(drifted, system.harmonics, 1.0)
    assert far.length((drifted, 0.0)) < 2.0, "a drift is measured against itself"
    equation = evaluate(system, excitation, drifted, w)
    assert equation.error > 100 * np.abs(equation.residual).max() / np.abs(drifted).max()
