"""Fits of a search, side by side: where they start, and how they are ordered and compared."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from updamp.diagnosis.candidate_models.attempts import Attempt, Bench, Done, Result
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Trial
from updamp.parallel.workers import Workers, here

Progress = Callable[[str], None]
# By the names of their effects.
Results = dict[tuple[str, ...], Result]


@dataclass(frozen=True, eq=False)
class Fits:
    """Of a search: where they start, what they are judged by, who is told, and where they are run.

    workers: for what leads to them: which effects look likely, and where their fits start
    """

    start: Baseline
    criteria: Criteria
    progress: Progress
    bench: Bench
    workers: Workers = here

    def results(self, attempts: Sequence[Attempt]) -> Results:
        found = self.bench(self.start, self.criteria, attempts, telling(self.progress))
        return {r.trial.effects: r for r in found if r is not None}

    def full(self, some: Sequence[Result], gated_again: bool = False) -> Results:
        return self.results(
            [Attempt(r.refit.effects, (), True, near=r.refit.fitted, gated_again=gated_again) for r in some]
        )


def best_first(found: Results) -> list[Result]:
    return sorted(found.values(), key=lambda r: -r.refit.drop)


def nearly(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    """Whether it takes off nearly as much of chi2 as the best one."""
    before = start.fitted.compared.excess
    comparable = one.excess < criteria.comparable * best.excess
    return comparable and before - one.excess > criteria.nearly * (before - best.excess)


def explains(trial: Trial, criteria: Criteria) -> bool:
    fails_elsewhere = trial.held_out**2 > criteria.look_further  # nan: there are none
    return trial.excess <= criteria.look_further and not fails_elsewhere


def telling(progress: Progress) -> Done:
    def done(attempt: Attempt, result: Result | None) -> None:
        left = "no response" if result is None else f"leaves {result.trial.excess**0.5:.2f} times the scatter"
        progress(f"{attempt.name}: {left}")

    return done
