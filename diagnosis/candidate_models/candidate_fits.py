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

    def explains(self, trial: Trial) -> bool:
        """Whether it leaves no more than chance may, on runs that it has not seen too: nothing else is looked for."""
        unseen = self.criteria.is_doubtful(trial.unseen, self.start.unseen_freedom)
        return not (self.criteria.is_doubtful(trial.excess, self.start.freedom) or unseen)

    def explains_believably(self, trial: Trial) -> bool:
        """Likewise, by a calibration that can be believed."""
        return self.explains(trial) and not self.is_far_off(trial)

    def may_lack_something(self, settled: Sequence[Refit]) -> bool:
        """Whether the model without effects may, or the data ask for one of those that were fitted."""
        asked = any(r.delta_bic >= self.criteria.delta_bic for r in settled)
        misfit = self.start.fitted.compared.mean_squared_misfit
        return asked or self.criteria.is_doubtful(misfit, self.start.freedom)

    def fails(self, trial: Trial) -> bool:
        """Whether it leaves more than chance can on the runs that it was fitted to."""
        return self.criteria.fails(trial.excess, self.start.freedom)

    def cannot_be_named(self, trial: Trial) -> bool:
        """Whether no verdict can rest on it: it fails, or asks for a calibration that nobody would believe."""
        return self.fails(trial) or self.is_far_off(trial)

    def is_far_off(self, trial: Trial) -> bool:
        """Whether it asks for a calibration that nobody would believe."""
        return self.criteria.is_far_off(trial.deviations, self.start.stated)


def best_first(found: CandidateFits) -> list[FittedCandidate]:
    return sorted(found.values(), key=lambda r: -r.refit.drop)


def most_promising(found: CandidateFits) -> list[FittedCandidate]:
    """By what they may leave: fits that were cut short by where they would go on to."""
    return sorted(found.values(), key=lambda r: r.refit.promised)


def better_of(some: CandidateFits, others: CandidateFits) -> CandidateFits:
    """All of them; of those that differ by the order of their effects the one that takes off more."""
    found = dict(some)
    for names, result in others.items():
        same = [n for n in found if set(n) == set(names)]
        if all(result.refit.drop > found[n].refit.drop for n in same):
            for n in same:
                del found[n]
            found[names] = result
    return found


def nearly(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    """Whether it takes off nearly as much of chi2 as the best one."""
    before = start.fitted.compared.mean_squared_misfit
    comparable = one.mean_squared_misfit < criteria.search.comparable * best.mean_squared_misfit
    return comparable and before - one.mean_squared_misfit > criteria.search.nearly * (
        before - best.mean_squared_misfit
    )


def reporting(progress: Progress) -> OnFitted:
    def done(task: FitTask, result: FittedCandidate | None) -> None:
        if result is None:
            left = "the same minimum again, or no response" if task.size != 1 else "no response"
        else:
            left = f"leaves {result.trial.excess**0.5:.2f} times the scatter"
        progress(f"{task.name}: {left}")

    return done
