"""The branch in observed coordinates: against the linear receptance, its derivatives against differences."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import SENSORS, condition, parametrisation

from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.predicted_branch import PredictedBranch, at_sizes, with_patterns
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.hbm.newton.newton import Arc, solve
from updamp.hbm.newton.observe import response


@pytest.fixture(scope="module")
def slipping():
    """As it is followed, with no points between: points of branches that are moved correspond."""
    return trace_branch(parametrisation(), np.zeros(4), replace(condition(60.0), noise=()))


def test_a_stuck_branch_is_the_receptance_of_the_linear_model():
    force, p = 0.1, parametrisation()
    branch = trace_branch(p, np.zeros(4), condition(force))
    system = p.base.system
    rows = np.array([system.free.row(point) for point, _ in SENSORS])
    place = np.linspace(branch.place[0], branch.place[-1], 300)
    observed = branch.at(place).value
    for f, pairs in zip(np.exp(observed[:, 0]), observed[:, 1:], strict=True):
        exact = force * system.stuck.receptance(2 * np.pi * f, rows, rows[:1])[:, 0]
        np.testing.assert_allclose(np.exp(pairs[0::2] + 1j * pairs[1::2]), exact, rtol=1e-3)


def test_the_contact_slips_and_the_branch_is_followed_through_the_window(slipping):
    stuck = trace_branch(parametrisation(), np.zeros(4), condition(0.1))
    top = np.abs(slipping.amplitude[:, 0]).max() / 60.0
    assert not 0.95 < top / (np.abs(stuck.amplitude[:, 0]).max() / 0.1) < 1.05
    assert slipping.frequency[0] < 40
    assert slipping.frequency[-1] > 50
    assert slipping.stopped == ""


@pytest.mark.parametrize("which", range(4))
def test_derivatives_by_the_parameters_against_branches_solved_anew(slipping, which, monkeypatch):
    u = np.zeros(4)
    u[which] = 2e-5
    monkeypatch.setattr(PredictedBranch, "thinned", lambda branch: branch)
    above, below = (move_branch(parametrisation(), sign * u, slipping) for sign in (1, -1))
    # all points, on the same planes across the branch, so that they correspond
    difference = (above.state - below.state) / (2 * u[which])
    scale = np.abs(difference).max(axis=0)
    # a point may lie so close to where the contact begins to slip that the change leads across it
    alike = np.all(np.abs(above.slopes[:, which] - below.slopes[:, which]) < 5e-3 * scale, axis=1)
    assert np.count_nonzero(~alike) <= 1
    np.testing.assert_allclose(slipping.slopes[alike, which] / scale, difference[alike] / scale, atol=5e-3)


def test_derivative_by_the_force_against_points_solved_anew(slipping):
    """On the planes across the branch through each point; what points move by along the branch is a matter of where
    the place on it is held, and is taken off."""
    model, step = parametrisation().base, 1e-3
    row = model.system.free.row("a.x")
    for i in range(2, len(slipping.points) - 2, 7):
        point, logs = slipping.points[i], []
        for sign in (1, -1):
            force = model.excited_by(60.0 * np.exp(sign * step))
            arc = Arc(point.x, point.w, point.tangent, point.metric)
            solution = solve(model.system, force, point.x, point.w, arc=arc)
            amplitude = model.harmonics.amplitude(response(solution.equation, force, np.array([row])), 1)[0]
            logs.append([np.log(solution.w), np.log(np.abs(amplitude)), np.angle(amplitude)])
        difference = (np.array(logs[0]) - np.array(logs[1])) / (2 * step)
        there = slipping.at(slipping.place[i])
        direction = there.along[:3] / np.linalg.norm(there.along[:3])
        left = there.slopes[-1, :3] - difference
        left -= (left @ direction) * direction
        assert np.all(np.abs(left) < [2e-4, 2e-3, 2e-3]), (i, left)


def test_moved_and_traced_branches_are_the_same_curve(slipping):
    p, u = parametrisation(), np.array([0.01, 0.2, -0.1, 0.02])
    moved, traced = move_branch(p, u, slipping), trace_branch(p, u, condition(60.0))
    dense = traced.at(np.linspace(traced.place[0], traced.place[-1], 50_000)).value
    inside = (moved.frequency > 40) & (moved.frequency < 50)
    apart = [np.abs(dense - value).max(axis=1).min() for value in moved.at(moved.place[inside]).value]
    assert np.median(apart) < 3e-4
    assert max(apart) < 5e-3  # between two points of the traced branch, where the contact begins to slip


def test_arrays_are_laid_out_as_after_a_way_between_processes(slipping):
    """Products with arrays laid out otherwise have other last digits."""
    moved = move_branch(parametrisation(), np.full(4, 1e-3), slipping)
    for branch in (slipping, moved):
        for array in (*branch.x_by_parameter, *(p.x for p in branch.points), *(p.tangent_x for p in branch.points)):
            assert array.flags.c_contiguous


# A branch with the sizes found for the patterns of numerical error is what the fit compares with.


def test_patterns_are_added_as_the_fit_adds_them() -> None:
    plain = trace_branch(parametrisation(), np.zeros(4), condition(40.0))
    observed = plain.at(plain.place).value
    n, m = observed.shape
    pattern = np.zeros((n, 1, m))
    pattern[:, 0] = [0.002, 0.05, 0.03, -0.04, 0.0]
    none = np.zeros((n, m))
    name = plain.condition.name
    numerics = NumericalError(("shift",), {name: observed}, {name: none}, {name: pattern}, {name: none})
    branch = with_patterns(plain, numerics)
    u = np.array([0, 0, 0, 0, 1.5])
    fitted = at_sizes(branch, u)
    place = np.linspace(branch.place[0], branch.place[-1], 200)
    before, after = branch.at(place), fitted.at(place)
    expected = before.value + before.slopes[:, 4] * 1.5
    turns = np.round((after.value - expected)[:, 2::2] / (2 * np.pi))
    expected[:, 2::2] += 2 * np.pi * turns
    np.testing.assert_allclose(after.value, expected, atol=1e-3)
    np.testing.assert_allclose(fitted.u, u)
    assert at_sizes(fitted, u) is fitted
    # a parameter of the model: the branch stands where it was solved
    np.testing.assert_array_equal(at_sizes(branch, np.array([0.1, 0, 0, 0, 0])).state, branch.state)
