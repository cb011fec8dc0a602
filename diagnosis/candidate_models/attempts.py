"""Fits with effects, here or in other processes: independent of each other, so that they can run side by side."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.fit import Fit, predict
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.diagnosis.candidate_models.baseline import Baseline, error_of, gated_again
from updamp.diagnosis.candidate_models.other_sizes import at_size, resized
from updamp.diagnosis.candidate_models.refit import FULL, Refit, Starts, judged, refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Trial
from updamp.effects.effect import Effect
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Attempt:
    """effects: further ones; starts: of their parameters in typical sizes, beside the calibrated model's
    as_given: likewise, beside the model's as it was before calibration
    near: a fit of the same to go on from; gated_again: whether its numerical error is found anew (`baseline.py`)
    size: of the effects, times that of `near`, to go on from (`other_sizes.py`)
    """

    effects: tuple[Effect, ...]
    starts: tuple[Floats, ...]
    full: bool
    near: Fit | None = None
    as_given: tuple[Floats, ...] = ()
    gated_again: bool = False
    size: float = 1.0

    @property
    def name(self) -> str:
        settled = self.near is not None and self.size == 1
        how = ", numerics anew" if self.gated_again else ", until settled" if settled else ""
        if self.size != 1:
            how = f", from {self.size:g} times the size{how}"
        return ", ".join(e.name for e in self.effects) + how


@dataclass(frozen=True, eq=False)
class Result:
    refit: Refit
    trial: Trial

    def with_fit(self, fitted: Fit) -> "Result":
        return replace(self, refit=replace(self.refit, fitted=fitted))


# Told which attempt is done, and its result: None where the model with the effects has no response.
Done = Callable[[Attempt, Result | None], None]
# What runs attempts, from a model that the effects are to be added to; results in the order of the attempts.
Bench = Callable[[Baseline, Criteria, Sequence[Attempt], Done], list[Result | None]]


@dataclass(frozen=True)
class RunBy:
    """A bench of workers."""

    workers: Workers

    def __call__(
        self, start: Baseline, criteria: Criteria, attempts: Sequence[Attempt], done: Done
    ) -> list[Result | None]:
        return self.workers(_run, (start, criteria), attempts, lambda place, result: done(attempts[place], result))


run_here = RunBy(here)


def without_branches(fitted: Fit) -> Fit:
    """What takes least room. The branches are to be traced again, with other points on them."""
    return replace(fitted, compared=replace(fitted.compared, branches=()))


def with_branches(fitted: Fit, start: Baseline, branches_of: Branches = in_turn) -> Fit:
    """The fit, with branches traced where it has none."""
    if fitted.compared.branches:
        return fitted
    branches = predict(fitted.parametrisation, fitted.u, start.train_plan, None, branches_of)
    return replace(fitted, compared=replace(fitted.compared, branches=branches))


def _run(shared: tuple[Baseline, Criteria], attempt: Attempt) -> Result | None:
    start, criteria = shared
    r = _refit(start, criteria, attempt)
    if r is None:
        return None
    held_out = error_of(r.fitted, start.held_out_plan) if attempt.full else float("nan")
    names = tuple(e.name for e in attempt.effects)
    return Result(r, Trial(names, r.excess, r.drop, r.delta_bic, held_out, r.at_bound, attempt.full))


def _refit(start: Baseline, criteria: Criteria, a: Attempt) -> Refit | None:
    if a.near is None or (a.size == 1 and not a.gated_again):
        starts = Starts(a.as_given, a.starts)
        return refit(start.fitted, start.train_plan, a.effects, starts, criteria, a.full, a.near)
    try:
        if not a.gated_again:
            found = resized(a.near, a.effects, a.size, start)
        else:
            found = gated_again(a.near if a.size == 1 else at_size(a.near, a.effects, a.size), start, FULL)
    except BranchStoppedError:
        return None
    return replace(judged(start.fitted, found, a.effects, criteria), gated_again=a.gated_again) if found else None
