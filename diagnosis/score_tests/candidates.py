"""Which effects are worth a refit, in what order, and where their fits start."""

from collections.abc import Callable, Sequence
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


def fit_tasks(
    start: Baseline,
    effects: Sequence[Effect],
    scored: Sequence[Score],
    criteria: Criteria,
    progress: Callable[[str], None],
    workers: Workers = here,
) -> list[FitTask]:
    """Short ones, the most promising first: by the score test; where the model fails badly, by turns with what effects
    of typical size could do.

    scored: about the model of `start`

    Without contacts fits are quick, and first order about a model whose curves jump says little of how much an effect
    would explain: all that calibration cannot imitate are worth one.
    """
    visible = [s for s in scored if s.visibility >= criteria.visibility]
    if start.fitted.parametrisation.base.contacts is None:
        return [FitTask((s.effect,), (), full=True) for s in visible]
    by_score = {s.effect.name: s for s in visible if _is_worth_a_fit(s, start, criteria)}
    if not fails_badly(start.fitted):
        far = _is_far_from_given(start)
        return [
            FitTask(
                (s.effect,), _starts(s.step), False, as_given=_sizes(s.effect) if far or s.effect.finite_step else ()
            )
            for s in by_score.values()
        ]
    worth = {s.effect.name for s in visible}
    tried = [e for e in effects if e.name in worth]
    by_probe = {p.effect.name: p for p in probes(start, tried, progress, workers)}
    found = []
    for name in _by_turns(tuple(by_probe), tuple(by_score)):
        probe = by_probe.get(name)
        given = (probe.start,) if probe else ()
        calibrated = _starts(by_score[name].step) if name in by_score else ()
        effect = next(e for e in effects if e.name == name)
        found.append(FitTask((effect,), calibrated, full=False, as_given=given))
    return found


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
