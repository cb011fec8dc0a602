"""Which effects are worth a refit, in what order, and where their fits start."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import FitTask
from updamp.diagnosis.candidate_models.refit import fails_badly
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.score_tests.probe import probes
from updamp.diagnosis.score_tests.score import Score
from updamp.effects.effect import Effect
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]
# Of a first guess, in typical sizes of an effect's parameters.
_FARTHEST = 3.0


def by_score(start: Baseline, scored: Sequence[Score], criteria: Criteria) -> list[FitTask]:
    """Short ones, those first that the score test finds most of in the data.

    scored: about the model of `start`

    Without contacts fits are quick, and first order about a model whose curves jump says little of how much an effect
    would explain: all that may show are worth one, in full.
    """
    showing = _may_show(scored, criteria)
    if start.fitted.parametrisation.base.contacts is None:
        return [FitTask((s.effect,), (), full=True) for s in showing]
    far = not fails_badly(start.fitted) and _is_far_from_given(start)
    return [
        FitTask((s.effect,), _starts(s.step), False, as_given=_sizes(s.effect) if far or s.effect.finite_step else ())
        for s in showing
        if _is_worth_a_fit(s, start, criteria)
    ]


def with_probes(
    start: Baseline, tasks: Sequence[FitTask], progress: Callable[[str], None], workers: Workers = here
) -> list[FitTask]:
    """Where the model fails badly fits start beside the model as given from where first order leads with an effect of
    typical size in it (`probe.py`), in place of from that size."""
    if not (tasks and fails_badly(start.fitted)):
        return list(tasks)
    starts = _probed(start, [effect for task in tasks for effect in task.effects], progress, workers)
    return [replace(task, as_given=starts.get(task.effects[0].name, ())) for task in tasks]


def by_turns(
    start: Baseline,
    effects: Sequence[Effect],
    scored: Sequence[Score],
    criteria: Criteria,
    progress: Callable[[str], None],
    workers: Workers = here,
) -> list[FitTask]:
    """Of a model that fails badly: by what effects of typical size could do, and by the score test, by turns.

    scored: as `by_score`
    """
    of_score = {task.effects[0].name: task for task in by_score(start, scored, criteria)}
    seen = {s.effect.name: s.effect for s in _may_show(scored, criteria)}
    starts = _probed(start, [e for e in effects if e.name in seen], progress, workers)
    ordered = _by_turns(tuple(starts), tuple(of_score))
    calibrated = {name: task.starts for name, task in of_score.items()}
    return [
        FitTask((seen[name],), calibrated.get(name, ()), full=False, as_given=starts.get(name, ())) for name in ordered
    ]


def _probed(
    start: Baseline, effects: Sequence[Effect], progress: Callable[[str], None], workers: Workers
) -> dict[str, tuple[Floats, ...]]:
    """Where probes lead, by the effect's name, the best first."""
    return {p.effect.name: p.starts for p in probes(start, effects, progress, workers)}


def _may_show(scored: Sequence[Score], criteria: Criteria) -> list[Score]:
    """Those that calibration cannot imitate, and those of which what it cannot imitate is in the data: a stiffer wire
    shifts all resonances for the most part, and the rest of it may still be what is missing."""
    return [s for s in scored if s.visibility >= criteria.visibility or s.score >= criteria.search.score]


def _by_turns(one: Sequence[str], other: Sequence[str]) -> list[str]:
    """Without repetition."""
    pairs = zip_longest(one, other)
    return list(dict.fromkeys(name for pair in pairs for name in pair if name is not None))


def _is_far_from_given(start: Baseline) -> bool:
    """Whether calibration has moved a parameter by more than it is uncertain by beforehand: the model as given then is
    another place to start from, and first order about the calibrated one may not even know the sign of an effect that
    has led it astray."""
    p = start.fitted.parametrisation
    n = len(p.nuisances)
    return bool(np.any(np.abs(start.fitted.u[:n]) > p.deviation[:n]))


def _is_worth_a_fit(scored: Score, start: Baseline, criteria: Criteria) -> bool:
    """By the score test; where first order does not hold over an effect's size, wherever the model may lack
    something."""
    if scored.score >= criteria.search.score:
        return True
    misfit = start.fitted.compared.mean_squared_misfit
    return scored.effect.finite_step and criteria.is_doubtful(misfit, start.freedom)


def _sizes(effect: Effect) -> tuple[Floats, ...]:
    """Beside the model as given: there, and where an effect has no derivative at its null value, first order leads
    nowhere."""
    return tuple(np.array(size) for size in effect.sizes)


def _starts(step: Floats) -> tuple[Floats, ...]:
    """The linear guess, no further than some typical sizes, and where it is further that far too, else a part of it."""
    size = max(1.0, float(np.max(np.abs(step))) / _FARTHEST)
    return step / size, (step if size > 1 else step / 3)
