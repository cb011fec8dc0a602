"""Intervals by profile likelihood of the effects that a verdict speaks of: minutes are well spent on these alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.profile_likelihood import profile
from updamp.diagnosis.candidate_models.fit_tasks import without_branches
from updamp.diagnosis.candidate_models.intervals import in_units
from updamp.diagnosis.decision.decide import Decision
from updamp.diagnosis.selection.search import SearchResult
from updamp.effects.effect import EffectParameter
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.parallel.workers import Workers, here

Names = tuple[str, ...]
Interval = tuple[float, float]
# Of a fit's parameters, each as "effect.parameter", in its own unit.
Intervals = Mapping[str, Interval]


@dataclass(frozen=True, eq=False)
class _Task:
    """One parameter of an effect in a fit; names: of all effects that the fit has further; place: in u"""

    names: Names
    effect: str
    parameter: EffectParameter
    fitted: Fit
    place: int

    @property
    def name(self) -> str:
        return f"{self.effect}.{self.parameter.name}"


def profiles(
    found: SearchResult,
    decision: Decision,
    progress: Callable[[str], None] = lambda _: None,
    workers: Workers = here,
) -> dict[Names, Intervals]:
    """Of what the verdict rests on, and of what the data do not tell from it. Those of a model that has no response at
    its own parameters when it is solved again are left out."""
    trials = [t for t in (decision.trial, *decision.alternatives) if t is not None]
    tasks = [task for names in dict.fromkeys(t.effects for t in trials) for task in _tasks(found, names)]
    plan = found.baseline.train_plan
    made = workers(_interval, plan, tasks, lambda i, _: progress(f"interval of {tasks[i].name}"))
    intervals: dict[Names, dict[str, Interval]] = {}
    for task, interval in zip(tasks, made, strict=True):
        if interval is not None:
            intervals.setdefault(task.names, {})[task.name] = interval
    return dict(intervals)


def with_profiles(found: SearchResult, known: Mapping[Names, Intervals]) -> SearchResult:
    """The fits of the search, those that they are known of with these intervals"""
    refits = {
        names: replace(refit, profiles=known[names]) if names in known else refit
        for names, refit in found.refits.items()
    }
    return replace(found, refits=refits)


def _tasks(found: SearchResult, names: Names) -> Sequence[_Task]:
    refit = found.refits.get(names)
    if refit is None:
        return ()
    lean, p = without_branches(refit.fitted), refit.fitted.parametrisation
    return [
        _Task(names, effect.name, q, lean, p.columns(effect.name).start + i)
        for effect in p.effects
        for i, q in enumerate(effect.parameters)
    ]


def _interval(plan: Plan, task: _Task) -> Interval | None:
    try:
        return in_units(task.parameter, profile(task.fitted, plan, task.place).interval)
    except BranchStoppedError:
        return None
