"""Fits with effects, here or in other processes: independent of each other, so that they can run side by side."""

import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.effects.user_effect import effect_from_file
from updamp.diagnosis.residual.fit import Fit, predict
from updamp.diagnosis.search.baseline import Baseline, error_of
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.evidence import Trial
from updamp.diagnosis.search.refit import FULL, Refit, Starts, judged, refit
from updamp.diagnosis.search.regate import gated_again
from updamp.diagnosis.search.resized import at_size, resized
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.continuation import BranchStoppedError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Attempt:
    """effects: further ones; starts: of their parameters in typical sizes, beside the calibrated model's
    as_given: likewise, beside the model's as it was before calibration
    near: a fit of the same to go on from; gated_again: whether its numerical error is found anew (`regate.py`)
    size: of the effects, times that of `near`, to go on from (`resized.py`)
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


def run_here(start: Baseline, criteria: Criteria, attempts: Sequence[Attempt], done: Done) -> list[Result | None]:
    found = []
    for attempt in attempts:
        found.append(_run(start, criteria, attempt))
        done(attempt, found[-1])
    return found


@dataclass(frozen=True)
class RunElsewhere:
    """By an executor of processes, such as `concurrent.futures.ProcessPoolExecutor` or that of a Dask client.

    own: files of the user's own effects, which the other processes read too
    keep_compiled: whether they keep compiled contact laws, and use what is kept
    """

    executor: Executor
    own: tuple[Path, ...] = ()
    keep_compiled: bool = False

    def __call__(
        self, start: Baseline, criteria: Criteria, attempts: Sequence[Attempt], done: Done
    ) -> list[Result | None]:
        shared = _Task(self.own, self.keep_compiled, pickle.dumps(start), criteria)
        futures = {self.executor.submit(shared, pickle.dumps(a)): i for i, a in enumerate(attempts)}
        found: list[Result | None] = [None] * len(attempts)
        try:
            for future in as_completed(futures):
                place = futures[future]
                found[place] = future.result()
                done(attempts[place], found[place])
        finally:  # an interruption does not wait for what has not begun
            for future in futures:
                future.cancel()
        return found


def without_branches(fitted: Fit) -> Fit:
    """What takes least room. The branches are to be traced again, with other points on them."""
    return replace(fitted, compared=replace(fitted.compared, branches=()))


def with_branches(fitted: Fit, start: Baseline) -> Fit:
    """The fit, with branches traced where it has none."""
    if fitted.compared.branches:
        return fitted
    branches = predict(fitted.parametrisation, fitted.u, start.train_plan)
    return replace(fitted, compared=replace(fitted.compared, branches=branches))


def _run(start: Baseline, criteria: Criteria, attempt: Attempt) -> Result | None:
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


@dataclass(frozen=True)
class _Task:
    """What another process does. start: a pickled baseline. A user's effect can be unpickled only where its file has
    been read, so attempts come as bytes too."""

    own: tuple[Path, ...]
    keep_compiled: bool
    start: bytes
    criteria: Criteria

    def __call__(self, attempt: bytes) -> Result | None:
        _prepared(self.own, self.keep_compiled)
        return _run(_start(self.start), self.criteria, pickle.loads(attempt))


@lru_cache(maxsize=1)
def _prepared(own: tuple[Path, ...], kept: bool) -> None:
    """Once a process."""
    if kept:
        keep_compiled()
    for path in own:
        effect_from_file(path)


@lru_cache(maxsize=2)
def _start(shared: bytes) -> Baseline:
    start: Baseline = pickle.loads(shared)
    return start
