"""Fits on their way to other processes: what is left out of them is made again exactly."""

import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import condition, parametrisation, synthetic_plan

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.observed_point import with_matrices
from updamp.comparison.prediction.traced_branch import observe
from updamp.diagnosis.candidate_models import fit_tasks
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, with_branches, without_branches
from updamp.diagnosis.criteria import Criteria
from updamp.hbm.continuation.predictor_corrector import BranchStoppedError
from updamp.hbm.newton.newton import Status

U = np.array([0.0, 0.1, 0.05, 0.0])


@pytest.fixture(scope="module")
def plan() -> Plan:
    return synthetic_plan(parametrisation(), U, (condition(60.0),), np.zeros(4), seed=1, repeats=1)[0]


@pytest.fixture(scope="module")
def fitted(plan) -> Fit:
    p = parametrisation()
    scatter = Scatter({n.name: n.scatter for n in p.nuisances})
    return Fit(p, compare_at(p, U, plan, predict_branches(p, U, plan), scatter), np.eye(4), "")


def test_branches_keep_no_matrices_and_are_differentiated_the_same_with_them_again(fitted):
    assert len(pickle.dumps(without_branches(fitted))) < len(pickle.dumps(fitted)) < 2**20
    (branch,) = pickle.loads(pickle.dumps(fitted)).compared.branches
    assert all(point.solution.equation is None for point in branch.points)
    there = ModelAt(fitted.parametrisation, U)
    points = with_matrices(there, branch.condition, branch.points)
    again = observe(there, branch.condition, points, branch.stopped)
    for found, kept in ((again.slopes, branch.slopes), (again.state, branch.state)):
        np.testing.assert_allclose(found, kept, rtol=0, atol=1e-9 * np.abs(kept).max())


def test_branches_that_are_missing_are_traced_and_all_else_is_left(fitted, plan):
    lean = replace(fitted, compared=replace(without_branches(fitted).compared, left=(3.0,)))
    found = with_branches(lean, SimpleNamespace(train_plan=plan)).compared
    (branch,), (before,) = found.branches, fitted.compared.branches
    np.testing.assert_allclose(branch.frequency, before.frequency)
    assert found.left == (3.0,)


def test_a_fit_with_its_own_numerical_error_begins_with_runs_compared_with_branches(fitted, plan, monkeypatch):
    """A fit that was kept without them may have been compared with branches that had other points."""
    begun: list[Fit] = []
    monkeypatch.setattr(fit_tasks, "with_own_numerics", lambda near, *_: begun.append(near))
    stale = replace(fitted.compared.matched[0], place=np.zeros(40))
    lean = replace(fitted, compared=replace(fitted.compared, branches=(), matched=(stale,)))
    start = SimpleNamespace(train_plan=plan)
    assert fit_tasks._refit(start, Criteria(), FitTask((), (), True, near=lean, own_numerics=True)) is None
    np.testing.assert_allclose(begun[0].compared.matched[0].place, fitted.compared.matched[0].place)


def test_a_model_without_a_response_in_a_run_that_was_held_out_is_none(fitted, plan, monkeypatch):
    """The whole diagnosis ended, with "the branch stops": a level of 80 m/s2 that a slider could not be held at."""

    def stops(*_):
        raise BranchStoppedError(78.9, 3.7e-4, Status.TOO_MANY_ITERATIONS, "80 m/s2")

    monkeypatch.setattr(fit_tasks, "_refit", lambda *_: SimpleNamespace(fitted=fitted))
    monkeypatch.setattr(fit_tasks, "prediction_error", stops)
    start = SimpleNamespace(held_out_plan=plan)
    assert fit_tasks._run((start, Criteria()), FitTask((), (), True)) is None


def test_whole_fits_are_left_as_they_are(fitted):
    assert with_branches(fitted, SimpleNamespace(train_plan=None)) is fitted
