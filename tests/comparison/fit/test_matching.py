"""Where on the branch a measured point is looked for."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import condition, parametrisation, synthetic_plan
from support.softening_beam import UP, at, softening_beam, whole

from updamp.comparison.fit.matching import match
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
    assert (np.abs(after.place - middle) > 0.999 * reach).all()
    np.testing.assert_allclose(after.place[~inside], before.place[~inside])


def test_nothing_along_the_branch_is_nearer_than_the_place_found(measured):
    """By what is left there, against 4000 places all along, the branch moved far from where it was solved."""
    branch, run = measured
    shift, noise = np.array([0.0, 1.0, 20.0, -20.0]), np.array([1e-5, 1e-3, 1e-3, 1e-3, 1e-3])
    run = replace(run, own=np.tile(noise, (len(run), 1)))
    found = match(branch, run, shift, np.zeros(4))
    dense = branch.at(np.linspace(branch.place[0], branch.place[-1], 4000))
    away = run.observed[:, None] - (dense.value + np.einsum("npm,p->nm", dense.slopes[:, :-1], shift))
    away[..., 2::2] -= 2 * np.pi * np.round(away[..., 2::2] / (2 * np.pi))
    least = np.sum((away / noise) ** 2, axis=2).min(axis=1)
    left = np.sum((found.difference / noise) ** 2, axis=1)
    assert least.max() > 1, "the shift counts"
    np.testing.assert_array_less(left, (1 + 1e-6) * least)


@pytest.mark.parametrize(
    ("known", "of_frequency"), [(1e-3, 1e-3), (0.03, 2e-6)], ids=["as amplitudes", "far better known"]
)
@pytest.mark.parametrize("upper", [False, True])
def test_where_there_are_two_motions_a_run_is_compared_with_the_one_that_it_is_on(upper, known, of_frequency):
    """Between 77.5 and 79.5 Hz: on the part that a sweep upwards leaves at 79.7 Hz, or on the one that it jumps to.

    However well frequencies are known: places that are tried lie much further apart, and the one whose frequency
    happens to be the nearest may be on the other part.
    """
    p = softening_beam()
    branch = trace_branch(p, at(p), UP)
    reference = whole(p, at(p), UP)
    first, last = (int(i) for i in (reference.frequency[:-1] > reference.frequency[1:]).nonzero()[0][[0, -1]])
    part = np.arange(last + 2, len(reference.points) - 1) if upper else np.arange(3, first - 1)
    part = part[(reference.frequency[part] > 77.5) & (reference.frequency[part] < 79.5)]
    value = reference.observed.value[part]
    noise = np.full(value.shape, known)
    noise[:, 0] = of_frequency
    run = Observations("up", 0, 1, value, noise, np.zeros(len(part)))
    found = match(branch, run, branch.u, np.zeros(len(branch.u)))
    assert len(part) > 3
    assert np.abs(found.residual).max() < 0.1
    assert np.abs(found.difference[:, 1]).max() < 1e-3
