"""Models that explain the data, each with the numerical error of its own: what is told of a mesh and of few harmonics
at another model's parameters is not to tell them apart, nor how large an effect is. An effect of the other sign is
another model."""

from dataclasses import replace

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate
from updamp.diagnosis.selection.other_minima import lowest_of, turned_round


def with_equal_numerics(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """The likeliest few of those that explain the data, where that makes others of them, or another sign is as likely
    (`single_effects.refits_with_own_numerics` is for those that do not explain them)."""
    search = fits.criteria.search
    if not fits.start.fitted.parametrisation.numerics.names:
        return {}
    explaining = [r for r in found.values() if r.trial.full and fits.explains(r.trial)]
    likeliest = sorted(explaining, key=lambda r: -r.refit.delta_bic)[: search.full]
    again = fits.full([r for r in likeliest if not r.refit.own_numerics], own_numerics=True)
    turned = turned_round(fits, [r for r in likeliest if _other_sign_comes_close(r, search.close)])
    results = ((r, _better(fits, r, again.get(r.trial.effects), turned.get(r.trial.effects))) for r in likeliest)
    return {r.trial.effects: better for r, better in results if better is not r}


def _other_sign_comes_close(fitted: FittedCandidate, close: float) -> bool:
    """As rivals come close to the best effect"""
    limit = close * fitted.refit.mean_squared_misfit
    return any(other.compared.mean_squared_misfit < limit for other in fitted.refit.elsewhere)


def _better(
    fits: FitContext, given: FittedCandidate, own: FittedCandidate | None, turned: FittedCandidate | None
) -> FittedCandidate:
    """With its own numerical error, whichever leaves less, unless that asks for a calibration that cannot be believed
    and the other does not; the lower one of two signs. It knows of minima that are as likely."""
    believed = fits.explains_believably
    best = given if own is None or (believed(given.trial) and not believed(own.trial)) else own
    if turned is not None:
        best = lowest_of([best, turned])
    if best is given:
        return given
    return replace(best, refit=replace(best.refit, also=(*best.refit.also, *given.refit.also)))
