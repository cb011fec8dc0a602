"""Where on the branch a measured point is looked for."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import condition, parametrisation, synthetic_plan
from support.softening_beam import UP, at, softening_beam, whole

from updamp.comparison.fit.matching import match, sweeps_from
from updamp.comparison.fit.observations import Observations
from updamp.comparison.prediction.traced_branch import trace_branch


@pytest.fixture(scope="module")
def measured():
    """A branch and a quiet run of the same model, some forty points"""
    p, c = parametrisation(), condition(60.0)
    plan, _ = synthetic_plan(p, np.zeros(4), (c,), np.zeros(4), seed=5, noise=1e-4, repeats=1)
    return trace_branch(p, np.zeros(4), c), plan.observations[0]


def test_nothing_is_compared_with_a_place_that_was_not_followed(measured):
    """The interval with most of the measured points is called a gap: they are compared with the branch beside it."""
    branch, run = measured
    before = match(branch, run, np.zeros(4), np.full(4, 1e-3))
    interval = np.searchsorted(branch.place, before.place) - 1
    most = int(np.bincount(interval).argmax())
    points = list(branch.points)
    points[most + 1] = replace(points[most + 1], after_gap=True)
    gap = replace(branch, points=tuple(points))
    after = match(gap, run, np.zeros(4), np.full(4, 1e-3))
    assert not gap.seen[most]
    inside = interval == most
    assert inside.sum() >= 2
    middle = (branch.place[most] + branch.place[most + 1]) / 2
    reach = (branch.place[most + 1] - branch.place[most]) / 2
    assert (np.abs(after.place - middle) > 0.6 * reach).all()
    np.testing.assert_allclose(after.place[~inside], before.place[~inside])


def test_nothing_along_the_branch_is_nearer_than_the_place_found(measured):
    """By what is left there, against 4000 places all along, the branch moved far from where it was solved."""
    branch, run = measured
    shift, noise = np.array([0.0, 1.0, 20.0, -20.0]), np.array([1e-5, 1e-3, 1e-3, 1e-3, 1e-3])
    run = replace(run, noise=np.tile(noise, (len(run), 1)))
    found = match(branch, run, shift, np.zeros(4))
    dense = branch.at(np.linspace(branch.place[0], branch.place[-1], 4000))
    away = run.observed[:, None] - (dense.value + np.einsum("npm,p->nm", dense.slopes[:, :-1], shift))
    away[..., 2::2] -= 2 * np.pi * np.round(away[..., 2::2] / (2 * np.pi))
    least = np.sum((away / noise) ** 2, axis=2).min(axis=1)
    left = np.sum((found.difference / noise) ** 2, axis=1)
    assert least.max() > 1, "the shift counts"
    np.testing.assert_array_less(left, (1 + 1e-6) * least)


def test_the_ways_of_a_sweep_begin_on_each_stretch_and_jump_at_folds():
    #                 0  1  2  3    4    5    6  7    8    9    10
    ahead = np.array([1, 2, 3, 2.5, 2.0, 1.5, 2, 2.5, 3.5, 3.2, 4])
    ways = sweeps_from(ahead, np.zeros(11, dtype=bool))
    assert [way.tolist() for way in ways] == [[0, 1, 2, 8, 10], [5, 6, 7, 8, 10], [9, 10]]
    # a piece before the eighth that was not followed: what comes there begins a stretch of its own
    apart = np.arange(11) == 6
    assert [way.tolist() for way in sweeps_from(ahead, apart)] == [[0, 1, 2, 8, 10], [6, 7, 8, 10], [9, 10]]


@pytest.mark.parametrize("upper", [False, True])
def test_a_run_that_begins_where_there_are_two_motions_is_compared_with_the_one_it_is_on(upper):
    """Upwards from 77.5 Hz: on the part that a sweep from 76.5 Hz leaves at 79.7 Hz, or on the one that it jumps to."""
    p = softening_beam()
    branch = trace_branch(p, at(p), replace(UP, latest_start=77.5))
    reference = whole(p, at(p), UP)
    first, last = (int(i) for i in (reference.frequency[:-1] > reference.frequency[1:]).nonzero()[0][[0, -1]])
    part = np.arange(last + 2, len(reference.points) - 1) if upper else np.arange(3, first - 1)
    part = part[(reference.frequency[part] > 77.5) & (reference.frequency[part] < 79.5)]
    value = reference.observed.value[part]
    noise = np.full(value.shape, 1e-3)
    run = Observations("up", 0, 1, value, noise, np.zeros(len(part)))
    found = match(branch, run, branch.u, np.zeros(len(branch.u)))
    assert len(part) > 3
    assert np.abs(found.residual).max() < 0.1
    assert np.abs(found.difference[:, 1]).max() < 1e-3
