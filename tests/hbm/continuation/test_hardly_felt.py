"""Resonances that the elements hardly feel, against the linear structure's own response."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from support.quadratic_spring import QuadraticSpring

from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters
from updamp.hbm.contact.stops import Stop
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.hardly_felt import with_hardly_felt_resonances
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

CHAIN = 2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
OMEGA_SQUARED, MODES = np.linalg.eigh(CHAIN)
ROW = np.array([[0]])


def cubic(stiffness):
    return ElementGroup(CubicSpring(), CubicParameters(jnp.array([stiffness])), ROW)


def slider(stiffness, limit):
    return ElementGroup(Jenkins(), JenkinsParameters(jnp.array([stiffness]), jnp.array([limit])), ROW)


def damped(K, ratio):
    omega_squared, X = np.linalg.eigh(K)
    return X @ np.diag(2 * ratio * np.sqrt(omega_squared)) @ X.T


def traced(K, C, element, group, observed, window, force=0.1, upwards=True):
    n, rows = len(K), np.eye(len(K))
    linear = from_matrices(np.eye(n), C, K, rows[[element]], {"driven": rows[0], "observed": rows[observed]})
    system = NonlinearSystem(linear, (group,), Harmonics((1, 3)), time_samples=64)
    excitation, window = Excitation(linear.row("driven"), force), tuple(np.array(window) / (2 * np.pi))
    request = CurveRequest("chain", excitation, window, ("observed",), upwards=upwards)
    return system, request, whole_curve(system, request)


def largest(K, C, observed, window):
    """Of the linear structure's receptance in the window, from its matrices"""
    w = np.linspace(*window, 2001)
    resonances = np.sqrt(np.linalg.eigvalsh(K))
    w = np.concatenate([w, *(r * (1 + np.linspace(-2e-3, 2e-3, 4001)) for r in resonances)])
    w = w[(window[0] < w) & (w < window[1])]
    dynamic = K - w[:, None, None] ** 2 * np.eye(len(K)) + 1j * w[:, None, None] * C
    return np.abs(np.linalg.solve(dynamic, np.eye(len(K), 1))[:, observed, 0]).max()


@pytest.mark.parametrize("upwards", [True, False])
@pytest.mark.parametrize("ratio", [1e-3, 1e-2])
@pytest.mark.parametrize("window", [(0.7, 1.85), (0.4, 2.1), (0.9, 1.1)])
def test_a_mode_with_a_node_at_the_element_has_its_peak(window, ratio, upwards):
    """Five masses in a row, an element at the middle one: two modes rest there."""
    C = damped(CHAIN, ratio)
    curve = traced(CHAIN, C, 2, cubic(1e-9), 0, window, upwards=upwards)[2]
    assert curve.complete
    assert curve.peak("observed")[1] == pytest.approx(largest(CHAIN, C, 0, window), rel=1e-4)


def test_a_slipping_element_leaves_such_a_peak_where_it_is_from_either_end():
    peaks = [
        traced(CHAIN, damped(CHAIN, 1e-3), 2, slider(0.5, 0.1), 0, (0.7, 1.85), upwards=upwards)[2].peak("observed")
        for upwards in (True, False)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-6)
    of_node_modes = abs(sum(MODES[0, k] ** 2 / (OMEGA_SQUARED[k] - 1 + 2e-3j) for k in (1, 3)))
    assert peaks[0][1] == pytest.approx(of_node_modes, rel=1e-4)


@pytest.mark.parametrize(("coupling", "ratio"), [(1e-4, 1e-5), (1e-3, 1e-5), (1e-2, 1e-4), (1e-2, 1e-3), (3e-2, 1e-3)])
def test_a_resonance_that_moves_the_element_a_little_in_a_narrow_band_has_its_peak(coupling, ratio):
    """By up to a third of its motion: the way there and back again is longer than a step, that across it is not."""
    K = np.array([[1.0, -coupling], [-coupling, 1.69]])
    C = 2 * ratio * np.diag([1.0, 1.3])
    curve = traced(K, C, 0, cubic(1e-9), 1, (1.1, 1.5), force=0.01)[2]
    assert curve.complete
    assert curve.peak("observed")[1] == pytest.approx(largest(K, C, 1, (1.1, 1.5)), rel=1e-3)


def test_a_point_that_hardly_moves_elsewhere_has_its_peak():
    """The told point is driven through the resonance alone: beside it its response is next to nothing."""
    K = np.array([[1.0, -1e-12], [-1e-12, 1.69]])
    C = np.diag([2e-3, 2e-3])
    curve = traced(K, C, 0, cubic(1e-9), 1, (1.1, 1.5), force=0.01)[2]
    assert curve.complete
    assert curve.peak("observed")[1] == pytest.approx(largest(K, C, 1, (1.1, 1.5)), rel=1e-3)


def test_nothing_is_put_in_where_the_elements_have_moved_the_resonance():
    """A hardening resonance far above that of small amplitudes, where the branch passes in long steps."""
    K, C = np.array([[1.0]]), np.array([[0.005]])
    system, request, curve = traced(K, C, 0, cubic(1.0), 0, (0.6, 2.0), force=0.02)
    assert curve.peak("observed")[0] > 1.2 / (2 * np.pi)
    coarse = replace(request, options=replace(request.options, largest_step=1.0))
    far = whole_curve(system, coarse)
    passing = np.abs(np.diff(far.frequency[np.abs(far.frequency - 1 / (2 * np.pi)) < 0.01])).max()
    assert passing > 0.005 / (4 * np.pi), "steps are longer than half the width"
    assert with_hardly_felt_resonances(system, coarse, far) is far


def shifted(driving, window, upwards, options=None):
    """A sharp mode that moves a hardening element a tenth as much as the strongly damped one does, told where it is
    nearly alone; hardly driven. The element's amplitude in the other mode stiffens it."""
    shapes = np.array([[1.0, 0.1]])
    points = {"driven": np.array([1.0, driving]), "observed": np.array([0.02, 1.0])}
    linear = from_matrices(np.eye(2), np.diag([0.15, 2e-4]), np.diag([1, 1.25**2]), shapes, points)
    system = NonlinearSystem(linear, (cubic(0.3),), Harmonics((1, 3)), time_samples=128)
    options = options or ContinuationOptions()
    excitation = Excitation(linear.row("driven"), 0.1)
    return whole_curve(system, CurveRequest("two", excitation, window, ("observed",), upwards=upwards, options=options))


@pytest.mark.parametrize("driving", [1e-4, 2e-3])
def test_a_resonance_that_was_shifted_by_half_widths_has_its_peak_in_any_window_from_either_end(driving):
    """By one half-width with the weaker driving, by nine with the stronger one."""
    dense = shifted(driving, (0.195, 0.203), True, ContinuationOptions(largest_step=0.02, first_step=0.01))
    assert len(dense) >= 150
    for window in ((0.18, 0.22), (0.1, 0.3), (0.02, 1.0)):
        for upwards in (True, False):
            curve = shifted(driving, window, upwards)
            assert curve.complete
            assert curve.peak("observed") == pytest.approx(dense.peak("observed"), rel=1e-3)


@pytest.mark.parametrize("law", [cubic(2e-2), slider(0.3, 1e-3)])
@pytest.mark.parametrize("masses", [8, 14])
def test_an_element_that_moves_by_round_off_alone_leaves_the_linear_response(masses, law):
    """Weakly coupled masses in a row, driven at one end, the element at the other: what the modes contribute to its
    motion cancels to 1e-9 of their sum and less, and Newton's method cannot solve for 1e-9 of that."""
    K = np.eye(masses) + 0.01 * (2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1))
    C = damped(K, 0.01)
    curves = [traced(K, C, masses - 1, law, 0, (0.93, 1.15), upwards=upwards)[2] for upwards in (True, False)]
    assert all(curve.complete for curve in curves)
    peaks = [curve.peak("observed")[1] for curve in curves]
    assert peaks == pytest.approx([largest(K, C, 0, (0.93, 1.15))] * 2, rel=1e-4)


@pytest.mark.parametrize(("force", "end"), [(10.0, 14.0), (10.0, 15.0), (20.0, 15.0)])
@pytest.mark.parametrize("detuned", [0.0, 1e-3])
def test_of_two_equal_parts_joined_by_a_stop_the_mode_that_leaves_it_at_rest_has_its_peak(force, end, detuned):
    """With the gap open both have modes of their own, at one frequency. On top of a motion that closes it there are one
    that moves both alike, at which the stop rests, and one against each other, and each is as like those as the other:
    half of the peaks were those of the second, some from both ends."""
    w, size, ratio = 20 * np.pi, 1e-3, 0.003
    K = w**2 * np.diag([1 + detuned, 1.0])
    linear = from_matrices(np.eye(2), 2 * ratio / w * K, K, np.array([[1.0, -1.0]]), {"one": np.array([1.0, 0.0])})
    stop = ElementGroup(Stop(), UnilateralParameters(jnp.array([w**2 / 2]), jnp.array([size / 2])), ROW)
    system = NonlinearSystem(linear, (stop,), Harmonics((0, 1, 2, 3)), time_samples=128)
    excitation = Excitation(linear.row("one"), 2 * ratio * w**2 * size * force)
    request = CurveRequest("two", excitation, (9.0, end), ("one",))
    curves = [whole_curve(system, replace(request, upwards=upwards)) for upwards in (True, False)]
    assert all(curve.complete for curve in curves)
    (f, peak), other = (curve.peak("one") for curve in curves)
    assert (f, peak) == pytest.approx(other, rel=1e-4)
    # half of the response is that of the mode that moves both alike, and it alone is at resonance there
    assert f == pytest.approx(10 * (1 + detuned / 4), rel=3e-4)
    assert peak * excitation.force == pytest.approx(size * force / 2, rel=0.03)


def test_a_branch_that_ends_just_beyond_a_point_leads_to_it_from_either_end():
    """Traced across its resonance, the branch's last chord ends a thousandth beyond the flank that it leads to: that
    was a gap of 0.2 % beside the top, from one end."""
    springs = (
        ElementGroup(QuadraticSpring(), CubicParameters(jnp.array([0.7])), ROW),
        ElementGroup(CubicSpring(), CubicParameters(jnp.array([0.05])), ROW + 1),
    )
    linear = from_matrices(np.eye(1), 6e-4 * np.eye(1), np.eye(1), np.ones((2, 1)), {"mass": np.eye(1)[0]})
    system = NonlinearSystem(linear, springs, Harmonics((0, 1, 2, 3, 4, 5)), time_samples=128)
    window = tuple(np.array([0.8, 1.2]) / (2 * np.pi))
    curves = [
        whole_curve(system, CurveRequest("1", Excitation(linear.row("mass"), 9e-4), window, ("mass",), upwards=upwards))
        for upwards in (True, False)
    ]
    assert all(curve.complete for curve in curves), [curve.stopped for curve in curves]
    assert curves[0].peak("mass") == pytest.approx(curves[1].peak("mass"), rel=1e-6)
