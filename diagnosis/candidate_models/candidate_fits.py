"""Fits of a search, side by side: where they start, and how they are ordered and compared."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import FitRunner, FitTask, FittedCandidate, OnFitted
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Trial
from updamp.parallel.workers import Workers, here

Progress = Callable[[str], None]
# By the names of their effects.
CandidateFits = dict[tuple[str, ...], FittedCandidate]


@dataclass(frozen=True, eq=False)
class FitContext:
    """What all fits of a search have in common: the model they start from, what they are judged by, who learns of
    their progress, and where they are run.

    workers: for what leads to fits: which effects look likely, and where their fits start
    """

    start: Baseline
    criteria: Criteria
    progress: Progress
    runner: FitRunner
    workers: Workers = here

    def results(self, tasks: Sequence[FitTask]) -> CandidateFits:
        found = self.runner(self.start, self.criteria, tasks, reporting(self.progress))
        return {r.trial.effects: r for r in found if r is not None}

    def full(self, some: Sequence[FittedCandidate], own_numerics: bool = False) -> CandidateFits:
        """The same fits left to settle; own_numerics: with the numerical error of their own models"""
        tasks = [FitTask(r.refit.effects, (), True, near=r.refit.fitted, own_numerics=own_numerics) for r in some]
        return self.results(tasks)


def best_first(found: CandidateFits) -> list[FittedCandidate]:
    return sorted(found.values(), key=lambda r: -r.refit.drop)


def nearly(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    """Whether it takes off nearly as much of chi2 as the best one."""
    before = start.fitted.compared.mean_squared_misfit
    comparable = one.mean_squared_misfit < criteria.comparable * best.mean_squared_misfit
    return comparable and before - one.mean_squared_misfit > criteria.nearly * (before - best.mean_squared_misfit)


def explains(trial: Trial, criteria: Criteria) -> bool:
    fails_elsewhere = trial.held_out**2 > criteria.look_further  # nan: there are none
    return trial.excess <= criteria.look_further and not fails_elsewhere


def reporting(progress: Progress) -> OnFitted:
    def done(task: FitTask, result: FittedCandidate | None) -> None:
        left = "no response" if result is None else f"leaves {result.trial.excess**0.5:.2f} times the scatter"
        progress(f"{task.name}: {left}")

    return done
