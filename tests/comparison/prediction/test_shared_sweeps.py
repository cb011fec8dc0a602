"""Sweeps up and down the same branch, which is followed once: each sees what it sees of one followed for it alone."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NOISE, condition, parametrisation
from support.softening_beam import DOWN, UP, at, softening_beam

from updamp.comparison.prediction.moved_branch import move_branch, move_sweeps
from updamp.comparison.prediction.refined import InterpolationOptions
from updamp.comparison.prediction.run_condition import same_sweeps
from updamp.comparison.prediction.traced_branch import trace_branch, trace_sweeps
from updamp.effects.catalogue import FAULTS

# As well as either of two branches is interpolated.
WITHIN = InterpolationOptions.error * NOISE


def visible(branch):
    """Frequencies and states, densely, of what the sweep sees, in the order of the sweep"""
    place = np.linspace(branch.place[0], branch.place[-1], 20 * len(branch.place))
    near = np.clip(np.searchsorted(branch.place, place, side="right") - 1, 0, len(branch.place) - 2)
    value = branch.at(place[branch.visited[near] & branch.visited[near + 1]]).value
    return np.exp(value[:, 0]), value[:, 1:]


def assert_seen_alike(one, alone, within):
    """But for where it jumps, which is known to a step of the branch.

    within: of logarithms of amplitudes, and phases
    """
    (f, found), (g, expected) = visible(one), visible(alone)
    up = alone.condition.upwards
    assert (f[-1] > f[0]) == (g[-1] > g[0]) == up
    order = np.argsort(g)
    jump = np.argmax(np.abs(np.diff(expected[order, 0])))
    low, high = alone.condition.window
    clear = (f > low) & (f < high) & (np.abs(f / g[order][jump] - 1) > 0.01)
    assert clear.sum() > 100
    for j in range(found.shape[1]):
        np.testing.assert_allclose(found[clear, j], np.interp(f[clear], g[order], expected[order, j]), atol=within)


@pytest.mark.parametrize("pair", [(DOWN, UP), (UP, DOWN)], ids=["down first", "up first"])
def test_both_sides_of_a_hysteresis_are_seen_from_either_end(pair):
    softening = softening_beam()
    shared = trace_sweeps(softening, at(softening), pair)
    for one, c in zip(shared, pair, strict=True):
        assert_seen_alike(one, trace_branch(softening, at(softening), c), 5e-3)
        assert (one.along[0, 0] > 0) == c.upwards
        assert not one.stopped
    u = at(softening, 2e-3)
    moved = move_sweeps(softening, u, shared[0], pair)
    for one, c in zip(moved, pair, strict=True):
        assert_seen_alike(one, trace_branch(softening, u, c), 5e-3)


def test_of_a_contact_that_slips_they_are_the_same_points_the_other_way_round():
    p, up = parametrisation(), condition(60.0)
    down = replace(up, name="down", upwards=False)
    one, other = trace_sweeps(p, np.zeros(4), (up, down))
    for name in ("state", "slopes", "w_by_parameter"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name)[::-1])
    np.testing.assert_array_equal(one.along, -other.along[::-1])
    np.testing.assert_allclose(one.place, other.place[-1] - other.place[::-1], rtol=1e-12)
    assert one.visited.all()
    assert other.visited.all()
    u = np.full(4, 1e-3)
    alone = move_branch(p, u, trace_branch(p, np.zeros(4), up))
    assert_seen_alike(move_sweeps(p, u, one, (up, down))[0], alone, WITHIN)


def test_a_window_that_is_narrower_on_one_side_is_covered_for_both():
    p = parametrisation()
    up, down = condition(60.0, window=(41.0, 49.0)), condition(60.0, upwards=False, window=(42.5, 50.0))
    for one, c in zip(trace_sweeps(p, np.zeros(4), (up, down)), (up, down), strict=True):
        assert one.condition == c
        assert_seen_alike(one, trace_branch(p, np.zeros(4), c), WITHIN)


@pytest.mark.parametrize(("fault", "size"), [("amplifier_drift", 1.0), ("resonance_drift", -1.0)])
def test_what_is_read_of_a_sweep_depends_on_its_direction(fault, size):
    """A gain that grows, or resonances that fall, from the start of each sweep to its end."""
    p = replace(parametrisation(), effects=(FAULTS[fault],))
    u, up = np.append(np.zeros(4), size), condition(60.0)
    down = replace(up, name="down", upwards=False)
    for one, c in zip(trace_sweeps(p, u, (up, down)), (up, down), strict=True):
        assert_seen_alike(one, trace_branch(p, u, c), WITHIN)


def test_tests_go_together_that_differ_in_direction_and_window_alone():
    up, down = condition(60.0), condition(60.0, upwards=False, window=(41.0, 50.0))
    tests = [up, condition(10.0), down, replace(up, sensors=up.sensors[:1]), replace(up, mode="second")]
    assert same_sweeps(tests) == [[0, 2], [1], [3], [4]]
