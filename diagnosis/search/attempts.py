"""Fits with effects, here or in other processes: independent of each other, so that they can run side by side."""

import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.residual.fit import Fit, predict
from updamp.diagnosis.search.baseline import Baseline, error_of
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.evidence import Trial
from updamp.diagnosis.search.refit import Refit, refit

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Attempt:
    """effects: further ones; starts: of their parameters in typical sizes; near: a fit of the same to go on from"""

    effects: tuple[Effect, ...]
    starts: tuple[Floats, ...]
    full: bool
    near: Fit | None = None

    @property
    def name(self) -> str:
        return ", ".join(e.name for e in self.effects) + (", until settled" if self.near is not None else "")


@dataclass(frozen=True, eq=False)
class Result:
    refit: Refit
    trial: Trial

    @property
    def slim(self) -> "Result":
        """Without the fit's branches."""
        return replace(self, refit=replace(self.refit, fitted=slim(self.refit.fitted)))


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
    """By an executor of processes, such as `concurrent.futures.ProcessPoolExecutor` or that of a Dask client."""

    executor: Executor

    def __call__(
        self, start: Baseline, criteria: Criteria, attempts: Sequence[Attempt], done: Done
    ) -> list[Result | None]:
        shared = pickle.dumps(replace(start, fitted=slim(start.fitted)))
        futures = {
            self.executor.submit(_run_shared, shared, criteria, replace(a, near=a.near and slim(a.near))): i
            for i, a in enumerate(attempts)
        }
        found: list[Result | None] = [None] * len(attempts)
        for future in as_completed(futures):
            place = futures[future]
            found[place] = future.result()
            done(attempts[place], found[place])
        return found


def slim(fitted: Fit) -> Fit:
    """Without its branches, whose solved points carry large matrices."""
    return replace(fitted, compared=replace(fitted.compared, branches=()))


def _run(start: Baseline, criteria: Criteria, attempt: Attempt) -> Result | None:
    r = refit(start.fitted, start.train_plan, attempt.effects, attempt.starts, criteria, attempt.full, attempt.near)
    if r is None:
        return None
    held_out = error_of(r.fitted, start.held_out_plan) if attempt.full else float("nan")
    names = tuple(e.name for e in attempt.effects)
    return Result(r, Trial(names, r.excess, r.drop, r.delta_bic, held_out, r.at_bound, attempt.full))


def _run_shared(shared: bytes, criteria: Criteria, attempt: Attempt) -> Result | None:
    found = _run(_start(shared), criteria, attempt)
    return found and found.slim


@lru_cache(maxsize=2)
def _start(shared: bytes) -> Baseline:
    start: Baseline = pickle.loads(shared)
    return replace(start, fitted=with_branches(start.fitted, start))


def with_branches(fitted: Fit, start: Baseline) -> Fit:
    """A slim fit made whole again."""
    if fitted.compared.branches:
        return fitted
    branches = predict(fitted.parametrisation, fitted.u, start.train_plan)
    return replace(fitted, compared=replace(fitted.compared, branches=branches))
