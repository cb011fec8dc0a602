"""A third and further effects, one by one, where two are not enough; each for any other in what is found."""

from collections.abc import Iterator, Sequence

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, better_of, nearly
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate
from updamp.diagnosis.selection.beside import beside
from updamp.effects.effect import Effect


def further_effects(
    fits: FitContext, effects: Sequence[Effect], singles: CandidateFits, pairs: CandidateFits
) -> CandidateFits:
    """Beside the likeliest pair, and where that does not come to explain the data beside the next one that explains
    nearly as much: two effects less in common are further apart than exchanges of single ones lead.

    Of models without contacts alone: theirs are fitted in seconds.
    """
    found: CandidateFits = {}
    if fits.start.fitted.parametrisation.base.contacts is not None:
        return found
    for first in _starts(fits, pairs):
        led_to = _likeliest(found)
        if led_to is not None and (
            fits.explains(led_to.trial) or set(first.trial.effects) <= set(led_to.trial.effects)
        ):
            continue
        found |= _one_by_one(fits, effects, first, singles | pairs | found)
    return found


def _starts(fits: FitContext, pairs: CandidateFits) -> Iterator[FittedCandidate]:
    """The likeliest first; none where a verdict can rest on that."""
    ranked = sorted(pairs.values(), key=lambda r: -r.refit.delta_bic)[: fits.criteria.search.starts]
    if ranked and not fits.cannot_be_named(ranked[0].trial):
        return
    yield from (r for r in ranked if nearly(r.refit, ranked[0].refit, fits.start, fits.criteria))


def _one_by_one(
    fits: FitContext, effects: Sequence[Effect], first: FittedCandidate, known: CandidateFits
) -> CandidateFits:
    """Beside a pair, then beside the likeliest three, as long as no verdict can rest on what is found, each effect more
    is asked for by the data and makes runs that the fit never saw better predicted."""
    found: CandidateFits = {}
    best = first
    while fits.cannot_be_named(best.trial) and _is_asked_for(fits, best):
        more = _one_more(fits, effects, best, known | found)
        found |= more
        after = _likeliest(more)
        if after is None or after.trial.held_out >= (1 - fits.criteria.gain) * best.trial.held_out:
            break
        best = after
    return found


def _one_more(
    fits: FitContext, effects: Sequence[Effect], best: FittedCandidate, known: CandidateFits
) -> CandidateFits:
    """One effect more beside the best, then any one of the likeliest for any other until none is likelier: an effect in
    it may only have stood in for another, whether it explains the data or not (A. J. Miller, Subset Selection in
    Regression (2002), chapter 3, sequential replacement)."""
    found = beside(fits, best.refit, effects, known)
    at = _likeliest(found)
    while at is not None and _is_asked_for(fits, at):
        found = better_of(found, _others_in_turn(fits, effects, at, known | found))
        better = _likeliest(found)
        if better is at:
            break
        at = better
    return found


def _others_in_turn(
    fits: FitContext, effects: Sequence[Effect], at: FittedCandidate, known: CandidateFits
) -> CandidateFits:
    """What it is without one of its effects, with any that was not tried there yet."""
    found: CandidateFits = {}
    for left_out in at.trial.effects:
        rest = frozenset(at.trial.effects) - {left_out}
        found |= _fitted_with(fits, effects, rest, known | found)
        part = _with_effects(known | found, rest)
        tried = [frozenset(names) - rest for names in (*known, *found) if rest < frozenset(names)]
        others = [e for e in effects if e.name != left_out and {e.name} not in tried]
        if part is not None and others:
            found |= beside(fits, part.refit, others, known | found)
    return found


def _fitted_with(
    fits: FitContext, effects: Sequence[Effect], names: frozenset[str], known: CandidateFits
) -> CandidateFits:
    """The fit with these effects, where there is none yet, beside the likeliest of those that have one less."""
    if _with_effects(known, names) is not None:
        return {}
    fewer = {some: r for some, r in known.items() if frozenset(some) < names and len(some) == len(names) - 1}
    first = _likeliest(fewer)
    if first is None:
        return {}
    return beside(fits, first.refit, [e for e in effects if e.name in names], known)


def _with_effects(some: CandidateFits, names: frozenset[str]) -> FittedCandidate | None:
    return next((r for found, r in some.items() if frozenset(found) == names), None)


def _is_asked_for(fits: FitContext, one: FittedCandidate) -> bool:
    return one.trial.delta_bic >= fits.criteria.delta_bic


def _likeliest(some: CandidateFits) -> FittedCandidate | None:
    return max(some.values(), key=lambda r: r.refit.delta_bic, default=None)
