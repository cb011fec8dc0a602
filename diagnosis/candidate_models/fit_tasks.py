"""Fits of candidate models as tasks that do not depend on each other: run here, or side by side in other processes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.prediction_error import PredictionError, prediction_error
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.diagnosis.candidate_models.baseline import (
    Baseline,
    farthest_off,
    with_numerics_of_its_start,
    with_own_numerics,
)
from updamp.diagnosis.candidate_models.if_repeatable import if_repeatable
from updamp.diagnosis.candidate_models.intervals import may_be_absent
from updamp.diagnosis.candidate_models.other_sizes import fit_from_size, with_size
from updamp.diagnosis.candidate_models.refit import FULL, Refit, Starts, assessed, refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Trial
from updamp.effects.effect import Effect
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FitTask:
    """A candidate model, and how it is to be fitted.

    effects: further ones; starts: of their parameters in typical sizes, beside the calibrated model's
    as_given: likewise, beside the model's as it was before calibration
    full: whether the fit is left to settle; near: a fit of the same to go on from
    own_numerics: whether the numerical error is to be that of the model with the effects
    size: of the effects, times that of `near`, to go on from (`other_sizes.py`)
    near_own: whether `near` has the numerical error of its own model, which is another fit to go on from
    """

    effects: tuple[Effect, ...]
    starts: tuple[Floats, ...]
    full: bool
    near: Fit | None = None
    as_given: tuple[Floats, ...] = ()
    own_numerics: bool = False
    size: float = 1.0
    near_own: bool = False

    @property
    def name(self) -> str:
        settled = self.near is not None and self.size == 1
        how = ", with its own numerical error" if self.own_numerics else ", until settled" if settled else ""
        if self.size != 1:
            how = f", from {self.size:g} times the size{' by its own numerics' if self.near_own else ''}{how}"
        return (", ".join(e.name for e in self.effects) or "without effects") + how


@dataclass(frozen=True, eq=False)
class FittedCandidate:
    """A candidate model as fitted, and what the decision needs of it."""

    refit: Refit
    trial: Trial

    def with_fit(self, fitted: Fit) -> "FittedCandidate":
        return replace(self, refit=replace(self.refit, fitted=fitted))


# Called with a task that is done, and its result: None where the model with the effects has no response, in the runs of
# the fit or in one that was held out.
OnFitted = Callable[[FitTask, FittedCandidate | None], None]
# Runs tasks, from a model that the effects are to be added to; results in the order of the tasks.
FitRunner = Callable[[Baseline, Criteria, Sequence[FitTask], OnFitted], list[FittedCandidate | None]]


@dataclass(frozen=True)
class FitRunnerOf:
    """Fits run by workers."""

    workers: Workers

    def __call__(
        self, start: Baseline, criteria: Criteria, tasks: Sequence[FitTask], done: OnFitted
    ) -> list[FittedCandidate | None]:
        return self.workers(_run, (start, criteria), tasks, lambda place, result: done(tasks[place], result))


fit_here = FitRunnerOf(here)


def without_branches(fitted: Fit) -> Fit:
    """What takes least room. The branches are to be traced again, with other points on them."""
    return replace(fitted, compared=replace(fitted.compared, branches=()))


def with_branches(fitted: Fit, start: Baseline, branches_of: Branches = in_turn) -> Fit:
    """The fit, with branches traced where it has none. All else is left as it was found: what comes of it must not
    depend on whether it had been kept without them."""
    if fitted.compared.branches:
        return fitted
    branches = predict_branches(fitted.parametrisation, fitted.u, start.train_plan, None, branches_of)
    return replace(fitted, compared=replace(fitted.compared, branches=branches))


def _compared_anew(fitted: Fit, start: Baseline) -> Fit:
    """The fit, with branches traced, and runs compared with these, where it has none."""
    if fitted.compared.branches:
        return fitted
    traced = with_branches(fitted, start)
    c, plan = traced.compared, start.train_plan
    return replace(traced, compared=compare_at(traced.parametrisation, c.u, plan, c.branches, c.scatter, c.offsets))


def _run(shared: tuple[Baseline, Criteria], task: FitTask) -> FittedCandidate | None:
    start, criteria = shared
    r = _refit(start, criteria, task)
    try:
        return _assessed(start, task, r) if r is not None else None
    except BranchStoppedError:  # in a run that was held out: what it is to predict it has no answer to
        return None


def _assessed(start: Baseline, task: FitTask, r: Refit) -> FittedCandidate:
    """raises: BranchStoppedError where the model has no response in a run that was held out"""
    held_out = prediction_error(r.fitted, start.held_out_plan) if task.full else PredictionError()
    names = tuple(e.name for e in task.effects)
    calibration = farthest_off(r.fitted)
    misfit, gain = r.mean_squared_misfit, r.delta_bic
    parameters = sum(len(e.parameters) for e in task.effects)
    trial = Trial(
        names, misfit, r.drop, gain, held_out.error, r.at_bound, task.full, *calibration, parameters,
        unseen=held_out.misfit,
    )  # fmt: skip
    if not task.full:
        return FittedCandidate(r, trial)
    absent, others = may_be_absent(r.fitted), if_repeatable(r.fitted, start)
    return FittedCandidate(r, replace(trial, may_be_absent=absent, if_repeatable=others))


def _refit(start: Baseline, criteria: Criteria, a: FitTask) -> Refit | None:
    if a.near is None or (a.size == 1 and not a.own_numerics):
        starts = Starts(a.as_given, a.starts)
        return refit(start.fitted, start.train_plan, a.effects, starts, criteria, a.full, a.near, start.as_given)
    try:
        if not a.own_numerics:
            found = fit_from_size(a.near, a.effects, a.size, start)
        else:
            found = with_own_numerics(_solved(a, a.near, start), start, FULL)
    except BranchStoppedError:
        return None
    if found is None:
        return None
    return replace(assessed(start.fitted, found, start.train_plan, a.effects, criteria), own_numerics=a.own_numerics)


def _solved(a: FitTask, near: Fit, start: Baseline) -> Fit:
    """Where a fit with its own numerical error begins

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    if a.size == 1:
        return _compared_anew(near, start)
    return with_numerics_of_its_start(with_size(near, a.effects, a.size), start, FULL)
