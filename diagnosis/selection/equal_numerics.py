"""Of several models that explain the data, each with the numerical error of its own: what is told of a mesh and of few
harmonics at another model's parameters is not to tell them apart. An effect of the other sign is another model."""

from dataclasses import replace

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate
from updamp.diagnosis.selection.other_minima import lowest_of, turned_round


def with_equal_numerics(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """Those of the likeliest few that take off more then, or that another sign is as likely as. A fit that explains the
    data is left as it is where it is the only one, unless it asks for a calibration that nobody would believe: a
    resonance that a coarse mesh has elsewhere is one (`single_effects.refits_with_own_numerics` is for those that do
    not explain them)."""
    criteria = fits.criteria
    if not fits.start.fitted.parametrisation.numerics.names:
        return {}
    explaining = [r for r in found.values() if r.trial.full and fits.explains(r.trial)]
    likeliest = sorted(explaining, key=lambda r: -r.refit.delta_bic)[: criteria.search.full]
    turning = [r for r in likeliest if _other_sign_comes_close(r, criteria.search.close)]
    if len(likeliest) + len(turning) < 2 and not any(fits.is_far_off(r.trial) for r in likeliest):
        return {}
    again = fits.full([r for r in likeliest if not r.refit.own_numerics], own_numerics=True)
    turned = turned_round(fits, turning)
    results = ((r, _better(fits, r, again.get(r.trial.effects), turned.get(r.trial.effects))) for r in likeliest)
    return {r.trial.effects: better for r, better in results if better is not r}


def _other_sign_comes_close(fitted: FittedCandidate, close: float) -> bool:
    """As rivals come close to the best effect"""
    limit = close * fitted.refit.mean_squared_misfit
    return any(other.compared.mean_squared_misfit < limit for other in fitted.refit.elsewhere)


def _better(
    fits: FitContext, given: FittedCandidate, own: FittedCandidate | None, turned: FittedCandidate | None
) -> FittedCandidate:
    """The lowest one, which knows of minima that are as likely; one whose calibration can be believed before others:
    the numerical error of another model may leave a little less by taking a run's resonance elsewhere."""
    best = max(
        (r for r in (given, own) if r is not None), key=lambda r: (fits.explains_believably(r.trial), r.refit.drop)
    )
    if turned is not None:
        best = lowest_of([best, turned])
    if best is given:
        return given
    return replace(best, refit=replace(best.refit, also=(*best.refit.also, *given.refit.also)))
