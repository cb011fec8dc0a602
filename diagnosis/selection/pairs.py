"""Two effects, where one is not enough."""

from collections.abc import Sequence

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, best_first, better_of, nearly
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, FittedCandidate
from updamp.diagnosis.candidate_models.minima import minima
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.selection.beside import beside
from updamp.diagnosis.selection.single_effects import refits_with_own_numerics
from updamp.effects.effect import Effect


def try_pairs(fits: FitContext, effects: Sequence[Effect], singles: CandidateFits) -> CandidateFits:
    """Second effects beside the best single one, where that leaves a misfit or explains it by more of itself than there
    can be, or by a calibration that nobody would believe, and beside the next one where it explains nearly as much:
    with a second effect beside them the two may change places."""
    start, criteria = fits.start, fits.criteria
    full = best_first({names: r for names, r in singles.items() if r.trial.full})
    settled = [r.refit for r in full]
    if not effects or not settled or settled[0].drop <= 0 or not fits.may_lack_something(settled):
        return {}
    doubtful = criteria.is_doubtful(settled[0].mean_squared_misfit, start.freedom)
    if not (doubtful or settled[0].at_bound or fits.is_far_off(full[0].trial)):
        return {}
    found: CandidateFits = {}
    if start.fitted.parametrisation.base.contacts is None:
        return _all_pairs(fits, effects, settled, singles)
    for first in (settled[0], *(r for r in settled[1:2] if nearly(r, settled[0], start, criteria))):
        partners = _explaining_partners(fits, found)
        others = [e for e in effects if e.name in partners] if partners else effects
        found = better_of(found, _beside_its_minima(fits, first, others, singles))
    return found


def _beside_its_minima(
    fits: FitContext, first: Refit, effects: Sequence[Effect], singles: CandidateFits
) -> CandidateFits:
    """Beside one minimum of the first effect after the other, until a pair explains the data."""
    found: CandidateFits = {}
    for minimum in minima(first, fits.start, fits.criteria):
        found = better_of(found, beside(fits, minimum, effects, singles))
        if _explaining_partners(fits, found):
            break
    return found


def _explaining_partners(fits: FitContext, pairs: CandidateFits) -> set[str]:
    """Second effects of pairs that explain the data: whether they do so beside another first one too is what is left to
    ask."""
    return {second for (_, second), r in pairs.items() if r.trial.full and fits.explains(r.trial)}


def _all_pairs(
    fits: FitContext, effects: Sequence[Effect], firsts: Sequence[Refit], singles: CandidateFits
) -> CandidateFits:
    """Each effect beside every other, once: two that are missing together need not come close alone, and one may show
    beside the other and not the other way round. The better one goes first where both show.

    Once a pair explains the data, beside effects of such pairs alone, until there are no further ones: what explains
    the data as well differs from it by one effect after the other."""
    found: CandidateFits = {}
    waiting = list(firsts)
    while (first := _next_first(fits, waiting, found)) is not None:
        waiting.remove(first)
        (one,) = first.effects
        fitted = {one.name} | {name for names in found if one.name in names for name in names}
        known = {r.effects[0].name for r in firsts} - fitted
        if known:
            found |= beside(fits, first, [e for e in effects if e.name in known], singles)
    return found


def _next_first(fits: FitContext, waiting: Sequence[Refit], pairs: CandidateFits) -> Refit | None:
    explaining = {name for names, r in pairs.items() if fits.explains_believably(r.trial) for name in names}
    return next((r for r in waiting if not explaining or r.effects[0].name in explaining), None)


def exchanged(
    fits: FitContext, effects: Sequence[Effect], singles: CandidateFits, pairs: CandidateFits
) -> tuple[CandidateFits, CandidateFits]:
    """Where the best pair still fails though its second effect helps: that one alone, and others beside it. The first
    was chosen by itself, and may only have stood in for what is missing.

    returns: further single effects, and all pairs
    """
    criteria, best = fits.criteria, _best(pairs)
    if best is None or not fits.fails(best.trial) or best.refit.delta_bic < criteria.delta_bic:
        return {}, pairs
    first, second = best.refit.effects
    if (1 + criteria.as_good) * best.trial.excess > singles[(first.name,)].trial.excess:
        return {}, pairs
    by_itself = fits.results([_as_in(best, second)])
    further = {names: r for names, r in by_itself.items() if names not in singles or not singles[names].trial.full}
    found = pairs
    for r in by_itself.values():
        others = [e for e in effects if e.name != first.name]
        found = better_of(found, beside(fits, r.refit, others, {**singles, **further}))
    return further, found


def _best(pairs: CandidateFits) -> FittedCandidate | None:
    return min(pairs.values(), key=lambda r: r.trial.excess, default=None)


def _as_in(pair: FittedCandidate, effect: Effect) -> FitTask:
    """The effect alone, from its size in the pair."""
    fitted = pair.refit.fitted
    start = fitted.u[fitted.parametrisation.columns(effect.name)]
    return FitTask((effect,), (start,), full=True, as_given=(start,))


def alone(fits: FitContext, singles: CandidateFits, pairs: CandidateFits) -> CandidateFits:
    """Second effects that have not been fitted in full alone, where one explains the data together with a first: it may
    be all that is missing, and the first one a wrong guess that has become small beside it. A short fit from elsewhere
    may have ended where the effect is absent."""
    best = _best(pairs)
    if best is None or fits.fails(best.trial):
        return {}
    second = best.refit.effects[1]
    known = singles.get((second.name,))
    if known is not None and known.trial.full:
        return {}
    tried = fits.results([_as_in(best, second)])
    found = {names: r for names, r in tried.items() if known is None or r.refit.drop > known.refit.drop}
    return found | refits_with_own_numerics(fits, found)
