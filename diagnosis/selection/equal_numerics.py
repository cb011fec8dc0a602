"""Of several models that explain the data, each with the numerical error of its own: what is told of a mesh and of few
harmonics at another model's parameters is not to tell them apart."""

from dataclasses import replace

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext


def with_equal_numerics(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """Those of the likeliest few that take off more then. A fit that explains the data is left as it is where it is the
    only one (`single_effects.refits_with_own_numerics` is for those that do not)."""
    criteria = fits.criteria
    if not fits.start.fitted.parametrisation.numerics.names:
        return {}
    explaining = [r for r in found.values() if r.trial.full and fits.explains(r.trial)]
    likeliest = sorted(explaining, key=lambda r: -r.refit.delta_bic)[: criteria.search.full]
    if len(likeliest) < 2:
        return {}
    again = fits.full([r for r in likeliest if not r.refit.own_numerics], own_numerics=True)
    return {
        names: replace(r, refit=replace(r.refit, also=found[names].refit.also))
        for names, r in again.items()
        if r.refit.drop > found[names].refit.drop
    }
