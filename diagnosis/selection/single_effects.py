"""Which single effect explains the data: short fits of those that look most likely, full ones of the best."""

from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from itertools import islice

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.candidate_fits import (
    CandidateFits,
    FitContext,
    best_first,
    most_promising,
    nearly,
)
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, FittedCandidate
from updamp.diagnosis.candidate_models.minima import knowing_of
from updamp.diagnosis.candidate_models.refit import Refit, fails_badly
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.score_tests.candidates import by_score, by_turns, with_probes
from updamp.diagnosis.score_tests.score import Score
from updamp.diagnosis.selection.other_minima import resized, turned_round, with_other_sign
from updamp.effects.effect import Effect


def try_singles(fits: FitContext, effects: Sequence[Effect], scored: Sequence[Score]) -> CandidateFits:
    """Short refits of those that look most likely, full ones of the best. Where the model fails badly the first one is
    taken alone, by the score test and by what effects of typical size could do: what leaves nothing of a large misfit
    is seldom one of several. What these could do is only asked of all where the score test alone has not led there, and
    before one is named: that takes a third of a search.

    fits: about the model that each is added to, which may have some already
    """
    start, criteria = fits.start, fits.criteria
    seen = by_score(start, scored, criteria)
    if start.fitted.parametrisation.base.contacts is None:
        return fits.results(seen)
    by_probes = cache(partial(by_turns, start, effects, scored, criteria, fits.progress, fits.workers))
    found: CandidateFits = {}
    badly, wanted = fails_badly(start.fitted), seen
    if badly:
        found = _in_turn(fits, [with_probes(start, seen[:1], fits.progress, fits.workers)], found)
        if _explaining(fits, found) is None:
            wanted = by_probes()
    likely = wanted[: criteria.search.short]
    half = (len(likely) + 1) // 2
    first = 1 if badly else half
    found = _in_turn(fits, (likely[:first], likely[first:half], likely[half:]), found)
    found |= _settled(fits, best_first(found)[:1], found, 1)
    if _explaining(fits, found) is None:
        found |= fits.full([r for r in _to_settle(fits, found) if not r.trial.full])
        found |= refits_with_own_numerics(fits, found)
        found |= _from_other_sizes(fits, found)
    found |= _rivals(fits, seen[: criteria.search.short], by_probes, found)
    found |= _settled(fits, most_promising(found), found, criteria.search.full)
    return found | refits_with_own_numerics(fits, found)


def _settled(fits: FitContext, some: Sequence[FittedCandidate], found: CandidateFits, most: int) -> CandidateFits:
    """Full fits of those that may be as good as the best one found, so many at most; some: in the order of interest"""
    best = best_first(found)[:1]
    short = [r for r in some if not r.trial.full and _gains_as_much(r.refit, best[0].refit, fits)]
    return fits.full(short[:most])


def _to_settle(fits: FitContext, found: CandidateFits) -> list[FittedCandidate]:
    """Those that promise most, by rank: short fits stop anywhere, with the numerical error of another model, and say
    little of what they would leave."""
    gaining = (r for r in most_promising(found) if r.refit.delta_bic > 0)
    return list(islice(gaining, fits.criteria.search.full))


def _in_turn(fits: FitContext, tasks: Iterable[Sequence[FitTask]], known: CandidateFits) -> CandidateFits:
    """With short fits of some after the others, until one explains the data: of the best, where it leaves little or no
    more than chance may, the full one too."""
    found, enough = dict(known), _left(fits.start, 1 - fits.criteria.search.promising)
    for some in tasks:
        if _explaining(fits, found):
            break
        found |= fits.results(_not_in(found, some))
        promising = [r for r in best_first(found)[:1] if r.trial.excess < enough or fits.explains(r.trial)]
        found |= fits.full([r for r in promising if not r.trial.full])
    return found


def _not_in(found: CandidateFits, tasks: Sequence[FitTask]) -> list[FitTask]:
    return [task for task in tasks if tuple(e.name for e in task.effects) not in found]


def refits_with_own_numerics(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """Full fits that take off most of a misfit, and yet leave some, or ask for a calibration that nobody would believe:
    with the numerical error of their own models, first those that come close to the best, then the others, by rank: how
    large that error is differs from model to model. Where none takes off most of it, those that the data ask for and
    that come close: this is to be known before a second effect is looked for, or none is said to explain them, and
    which is the best may hang on it."""
    start, criteria = fits.start, fits.criteria
    if not start.fitted.parametrisation.numerics.names:
        return {}
    settled = [r for r in best_first(found) if r.trial.full]
    most, least = _left(start, criteria.search.nearly), _least(settled)
    close = [r for r in settled[: criteria.search.full] if r.trial.excess < most]
    if not close:
        asked = (r for r in settled if r.refit.delta_bic >= criteria.delta_bic)
        close = [r for r in asked if r.trial.excess < criteria.search.close * least]
    left = [r for r in close if not (r.refit.own_numerics or fits.explains_believably(r.trial))]
    first = [r for r in left if r.trial.excess < criteria.search.close * least]
    again: CandidateFits = {}
    for some in (first, [r for r in left if r not in first]):
        again |= fits.full(some, own_numerics=True)
        if _explaining(fits, again) is not None:
            return again
    turned = turned_round(fits, with_other_sign(fits, left))
    return {
        r.trial.effects: lowest
        for r in left
        if (lowest := _lowest(r, again.get(r.trial.effects), turned.get(r.trial.effects))) is not r
    }


def _from_other_sizes(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """Where none of those with the numerical error of its own model explains the data, the best of them and those that
    come close, one after the other, until one does: before a second effect is looked for."""
    own = [r for r in best_first(found) if r.refit.own_numerics]
    most = min(_left(fits.start, fits.criteria.search.nearly), fits.criteria.search.close * _least(own))
    again: CandidateFits = {}
    for one in own:
        if one.trial.excess >= most or _explaining(fits, {**found, **again}) is not None:
            break
        again |= resized(fits, one)
    return again


def _least(some: Sequence[FittedCandidate]) -> float:
    return min((r.trial.excess for r in some), default=0.0)


def _lowest(given: FittedCandidate, own: FittedCandidate | None, turned: FittedCandidate | None) -> FittedCandidate:
    """The better one of two signs, with the numerical error of its own model where there is such a fit; it knows of the
    minima that the others ended at."""
    lowest = max((r for r in (own or given, turned) if r is not None), key=lambda r: r.refit.drop)
    return knowing_of(lowest, [r for r in (given, own, turned) if r is not None])


def _left(start: Baseline, share: float) -> float:
    """Mean squared misfit once so much of the misfit is taken off; what the scatter leaves, 1, is none"""
    return 1 + (1 - share) * (start.fitted.compared.mean_squared_misfit - 1)


def _comes_close(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    return one.promised < criteria.search.close * best.mean_squared_misfit or nearly(one, best, start, criteria)


def _explaining(fits: FitContext, found: CandidateFits) -> FittedCandidate | None:
    """The best one that explains the data, on runs that no fit saw too, by a calibration that can be believed. How far
    a short fit is off these is not asked."""
    good = (r for r in found.values() if r.trial.full and fits.explains_believably(r.trial))
    return min(good, key=lambda r: r.trial.excess, default=None)


def _rivals(
    fits: FitContext, likely: Sequence[FitTask], by_probes: Callable[[], Sequence[FitTask]], found: CandidateFits
) -> CandidateFits:
    """Where one explains the data, and they ask for it, all that look likely by the score test, and the others as they
    come by probes, which see what the score test does not where contacts begin to slip as an effect grows: two at a
    time, until neither comes close. Nothing is to be named that was not held against these."""
    best, criteria = _explaining(fits, found), fits.criteria
    if best is None or best.refit.delta_bic < criteria.delta_bic:
        return {}
    left, seen = _not_in(found, by_probes()), [task.effects for task in likely]
    others = [task for task in left if task.effects not in seen]
    rivals = fits.results([task for task in left if task.effects in seen])
    for first in range(0, len(others), 2):
        two = fits.results(others[first : first + 2])
        rivals |= two
        if not any(_gains_as_much(r.refit, best.refit, fits) for r in two.values()):
            break
    return rivals


def _gains_as_much(one: Refit, best: Refit, fits: FitContext) -> bool:
    """Whether it comes close to the best, or would to first order: a short fit may stop half-way, but has to gain
    something."""
    return one.delta_bic > 0 and _comes_close(one, best, fits.start, fits.criteria)
