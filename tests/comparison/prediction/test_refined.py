"""What is interpolated between the points of a branch is as good as the measurement asks for."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NOISE, condition, parametrisation

from updamp.comparison.prediction.model_at import model_at
from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.observed_point import Observer
from updamp.comparison.prediction.predicted_branch import logarithms
from updamp.comparison.prediction.refined import InterpolationOptions, deviation, refined
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.hbm.continuation.continuation import ContinuationOptions, continue_branch

FORCE = 60.0
NONE = np.zeros(4)


# Of Young's modulus, loss factor, friction and preload, as a fit moves them.
MOVED = np.array([0.01, 0.2, -0.1, 0.02])
NO_NOISE = replace(condition(FORCE), noise=())


@pytest.fixture(scope="module")
def coarse():
    """As it is followed, with no regard to a measurement."""
    return trace_branch(parametrisation(), NONE, NO_NOISE)


@pytest.fixture(scope="module")
def fine():
    return trace_branch(parametrisation(), NONE, condition(FORCE))


@pytest.fixture(scope="module")
def solved():
    """Points of the moved branch, close to each other."""
    p = parametrisation()
    there = model_at(p, MOVED, condition(FORCE))
    options = ContinuationOptions(first_step=0.02, largest_step=0.04)
    points = continue_branch(there.model.system, there.model.excited_by(FORCE), condition(FORCE).wider, options)
    return Observer(there, condition(FORCE))(list(points))


def off(branch, solved):
    """(n,) distance of solved points from the branch, at the same frequency, in standard deviations."""
    dense = branch.at(np.linspace(branch.place[0], branch.place[-1], 100_000)).value
    found = []
    for one in solved:
        seen, _ = logarithms(one.state[None], np.zeros((1, 0, len(one.state))))
        same = np.argmin(np.abs(dense[:, 0] - seen[:, 0]))
        found.append(np.linalg.norm((dense[same] - seen[0])[1:]) / NOISE)
    return np.array(found)


def test_a_branch_that_was_moved_has_its_points_where_the_contact_begins_to_slip_now(coarse, fine, solved):
    inside = [one for one in solved if 40 < np.exp(one.state[0]) < 50]
    before, after = (off(move_branch(parametrisation(), MOVED, branch), inside) for branch in (coarse, fine))
    assert before.max() > 0.2
    assert after.max() < 3 * InterpolationOptions.error
    assert np.sqrt(np.mean(after**2)) < InterpolationOptions.error / 2


def test_it_does_not_matter_where_the_points_were(solved):
    inside = [one for one in solved if 40 < np.exp(one.state[0]) < 50]
    for options in (None, ContinuationOptions(first_step=0.05, largest_step=0.06)):
        traced = trace_branch(parametrisation(), MOVED, condition(FORCE), options)
        assert off(traced, inside).max() < 3 * InterpolationOptions.error


def test_points_are_put_at_the_corner_and_hardly_elsewhere(coarse, fine):
    assert len(fine.points) < 2 * len(coarse.points)
    kept = {point.w for point in fine.points}
    assert all(point.w in kept for point in coarse.points)


def test_a_point_beside_a_cubic_is_as_far_off_as_it_lies_beside_it(solved):
    one = condition(FORCE)
    a, middle, b = solved[50], solved[51], solved[52]
    assert deviation([a], [middle], [b], one)[0] < 0.01
    turn = np.exp(0.3 * NOISE)
    beside = replace(middle, state=np.append(middle.state[0], turn * middle.state[1:]))
    assert deviation([a], [beside], [b], one)[0] == pytest.approx(0.3 * np.sqrt(2), rel=0.05)


def test_nothing_is_put_into_a_gap_or_where_nothing_is_asked_for(solved):
    points = [solved[25], solved[40].after_gap(), solved[55]]

    def between(_pairs):
        raise AssertionError("asked for a point between")

    assert refined(points, condition(FORCE), between) == points
    assert refined(solved[:20:4], NO_NOISE, between) == solved[:20:4]


def test_where_no_point_is_found_between_two_they_stay_as_they_are(solved):
    points = solved[:100:12]
    asked = []

    def between(pairs):
        asked.extend(pairs)
        return [None for _ in pairs]

    assert refined(points, condition(FORCE), between) == points
    assert asked


def test_what_stands_for_a_branch_as_a_whole_does_not_depend_on_its_points_and_is_not_taken_from_gaps(fine):
    denser = trace_branch(
        parametrisation(), NONE, condition(FORCE), ContinuationOptions(first_step=0.05, largest_step=0.06)
    )
    assert len(denser.points) > 1.3 * len(fine.points)
    medians = [np.sqrt(np.median(branch.evenly.slopes**2, axis=0)) for branch in (fine, denser)]
    np.testing.assert_allclose(medians[0], medians[1], rtol=0.1, atol=1e-3 * medians[0].max())
    i = len(fine.points) // 2
    split = replace(fine.points[i], after_gap=True)
    gap = replace(fine, points=(*fine.points[:i], split, *fine.points[i + 1 :]))
    for value in gap.evenly.value:
        assert not fine.observed.value[i - 1, 0] + 1e-12 < value[0] < fine.observed.value[i, 0] - 1e-12
