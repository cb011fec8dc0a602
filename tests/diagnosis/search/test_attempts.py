"""Fits on their way to other processes: what is left out of them is made again exactly."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import condition, parametrisation, synthetic_plan

from updamp.diagnosis.model.model_at import ModelAt
from updamp.diagnosis.model.predicted_branch import move_branch, observe
from updamp.diagnosis.residual.fit import Fit, compare_at, predict
from updamp.diagnosis.residual.scatter import Scatter
from updamp.diagnosis.search.attempts import slim, with_branches, without_branches

U = np.array([0.0, 0.1, 0.05, 0.0])


@pytest.fixture(scope="module")
def fitted() -> Fit:
    p = parametrisation()
    plan, _ = synthetic_plan(p, U, (condition(60.0),), np.zeros(4), seed=1, repeats=1)
    scatter = Scatter({n.name: n.scatter for n in p.nuisances})
    return Fit(p, compare_at(p, U, plan, predict(p, U, plan), scatter), np.eye(4), True, "")


def test_branches_go_without_their_matrices_and_are_the_same_again(fitted):
    sent = pickle.dumps(slim(fitted))
    assert len(pickle.dumps(without_branches(fitted))) < len(sent) < 0.6 * len(pickle.dumps(fitted))
    whole = with_branches(pickle.loads(sent), SimpleNamespace(train_plan=None))
    (before,), (after,) = fitted.compared.branches, whole.compared.branches
    there = ModelAt(fitted.parametrisation, U)
    for branch in (before, after):
        again = observe(there, branch.condition, branch.points, branch.stopped)
        np.testing.assert_array_equal(again.slopes, before.slopes)
        np.testing.assert_array_equal(again.state, before.state)


def test_a_slim_branch_can_be_moved(fitted):
    (whole,), (light,) = fitted.compared.branches, slim(fitted).compared.branches
    elsewhere = U + np.array([0, 0.02, 0.02, 0])
    one, other = (move_branch(fitted.parametrisation, elsewhere, b) for b in (whole, light))
    assert one is not None
    assert other is not None
    np.testing.assert_array_equal(one.state, other.state)


def test_whole_fits_are_left_as_they_are(fitted):
    assert with_branches(fitted, SimpleNamespace(train_plan=None)) is fitted
