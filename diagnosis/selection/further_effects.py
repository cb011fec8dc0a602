"""A third and further effects, one by one, where two are not enough."""

from collections.abc import Sequence

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, better_of
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate
from updamp.diagnosis.selection.beside import beside
from updamp.effects.effect import Effect


def further_effects(
    fits: FitContext, effects: Sequence[Effect], singles: CandidateFits, pairs: CandidateFits
) -> CandidateFits:
    """Beside the likeliest pair, then beside the likeliest three, as long as what is found still fails and each effect
    more is asked for by the data and makes runs that the fit never saw better predicted.

    Of models without contacts alone: theirs are fitted in seconds.
    """
    found: CandidateFits = {}
    if fits.start.fitted.parametrisation.base.contacts is not None:
        return found
    best, fewer = _likeliest(pairs), pairs
    while best is not None and fits.fails(best.trial) and best.trial.delta_bic >= fits.criteria.delta_bic:
        more = _one_more(fits, effects, best, fewer, singles | pairs | found)
        found = found | more
        after, fewer = _likeliest(more), more
        if after is None or after.trial.held_out >= (1 - fits.criteria.gain) * best.trial.held_out:
            break
        best = after
    return found


def _one_more(
    fits: FitContext, effects: Sequence[Effect], best: FittedCandidate, fewer: CandidateFits, known: CandidateFits
) -> CandidateFits:
    """One effect more beside the best; where that still fails, beside the others that the new best is made of too: an
    effect in it may only have stood in for what is missing. fewer: as many effects as in the best"""
    found = beside(fits, best.refit, effects, known)
    after = _likeliest(found)
    if after is None or not fits.fails(after.trial):
        return found
    parts = [r for names, r in fewer.items() if r is not best and set(names) < set(after.trial.effects)]
    for part in parts:
        found = better_of(found, beside(fits, part.refit, effects, known))
    return found


def _likeliest(some: CandidateFits) -> FittedCandidate | None:
    return max(some.values(), key=lambda r: r.refit.delta_bic, default=None)
