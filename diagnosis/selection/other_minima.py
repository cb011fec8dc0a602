"""Fits of the same effects from elsewhere: from other sizes, and from the other sign."""

from collections.abc import Sequence
from dataclasses import replace

from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, best_first, reporting
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, FittedCandidate, without_branches
from updamp.diagnosis.candidate_models.minima import knowing_of
from updamp.diagnosis.candidate_models.other_sizes import SIZE_FACTORS, as_likely, have_two_signs


def other_sizes(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """The best effect, where it explains the data, fitted from other sizes too, and from the other sign where it has
    two: the best of these fits, which knows of the others."""
    start, criteria = fits.start, fits.criteria
    explain = [r for r in best_first(found) if r.trial.full and not fits.fails(r.trial)]
    if not explain or explain[0].refit.delta_bic < criteria.delta_bic:
        return {}
    first = explain[0].refit
    sizes = (*SIZE_FACTORS, -1.0) if have_two_signs(first.effects) else SIZE_FACTORS
    go_on = FitTask(first.effects, (), True, near=first.fitted, near_own=first.own_numerics)
    tries = [replace(go_on, size=size) for size in sizes]
    tried = fits.runner(start, criteria, tries, reporting(fits.progress))
    best = lowest_of([explain[0], *(r for r in tried if r is not None)])
    return {best.trial.effects: replace(best, refit=replace(best.refit, own_numerics=first.own_numerics))}


def resized(fits: FitContext, one: FittedCandidate) -> CandidateFits:
    """The lowest of this fit and those from other sizes with the numerical error of these sizes, where it is another:
    what finer numerics change where a fit stands may keep it there, in a valley of its own. One after the other, until
    one explains the data. It knows of the others."""
    known = [one]
    for size in SIZE_FACTORS:
        task = FitTask(one.refit.effects, (), True, near=one.refit.fitted, own_numerics=True, size=size)
        known += fits.results([task]).values()
        if fits.explains_believably(known[-1].trial):
            break
    lowest = max(known, key=lambda r: r.refit.drop)
    return {} if lowest is one else {lowest.trial.effects: knowing_of(lowest, known)}


def turned_round(fits: FitContext, fitted: Sequence[FittedCandidate]) -> CandidateFits:
    """Fits with the numerical error of their own models from the other sign: a coarse mesh may show an effect of the
    right sign so weakly that a fit on it ends at the wrong one."""
    tries = [
        FitTask(r.refit.effects, (), True, near=r.refit.fitted, own_numerics=True, size=-1.0)
        for r in fitted
        if have_two_signs(r.refit.effects)
    ]
    return fits.results(tries) if tries else {}


def with_other_sign(fits: FitContext, fitted: Sequence[FittedCandidate]) -> list[FittedCandidate]:
    """Those that have a minimum at the other sign too, which does not leave many times as much: of others no finer mesh
    is asked there, which takes minutes."""
    two_signs = [r for r in fitted if have_two_signs(r.refit.effects)]
    tries = [FitTask(r.refit.effects, (), True, near=r.refit.fitted, size=-1.0) for r in two_signs]
    there, most = fits.results(tries) if tries else {}, fits.criteria.search.comparable
    return [
        r for r in two_signs if (o := there.get(r.trial.effects)) is not None and o.trial.excess < most * r.trial.excess
    ]


def lowest_of(some: Sequence[FittedCandidate]) -> FittedCandidate:
    """Of fits of the same effects. It knows of those that the data do not tell from it, and of the lowest of each sign
    (`knowing_of`)."""
    best = max(some, key=lambda r: r.refit.drop)
    also = [r.refit.fitted for r in some if r is not best and as_likely(r.refit.fitted, best.refit.fitted)]
    best = replace(best, refit=replace(best.refit, also=tuple(without_branches(f) for f in also)))
    return knowing_of(best, some)
