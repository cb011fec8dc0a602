"""Which single effect explains the data: short fits of those that look most likely, full ones of the best."""

from collections.abc import Sequence
from dataclasses import replace

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.candidate_fits import (
    CandidateFits,
    FitContext,
    best_first,
    nearly,
    reporting,
)
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, FittedCandidate, without_branches
from updamp.diagnosis.candidate_models.other_sizes import SIZE_FACTORS, as_likely, have_two_signs
from updamp.diagnosis.candidate_models.refit import Refit, fails_badly
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.score_tests.candidates import fit_tasks
from updamp.diagnosis.score_tests.score import Score
from updamp.effects.effect import Effect


def try_singles(fits: FitContext, effects: Sequence[Effect], scored: Sequence[Score]) -> CandidateFits:
    """Short refits of those that look most likely, full ones of the best. Where the model fails badly the first one is
    taken alone: what leaves nothing of a large misfit is seldom one of several."""
    start, criteria = fits.start, fits.criteria
    wanted = fit_tasks(start, effects, scored, criteria, fits.progress, fits.workers)
    if all(task.full for task in wanted):
        return fits.results(wanted)
    likely = wanted[: criteria.search.short]
    half, enough = (len(likely) + 1) // 2, _left(start, 1 - criteria.search.promising)
    found: CandidateFits = {}
    first = 1 if fails_badly(start.fitted) else half
    for some in (likely[:first], likely[first:half], likely[half:]):
        if _explaining(fits, found):
            break
        found |= fits.results(some)
        promising = [r for r in best_first(found)[:1] if r.trial.excess < enough]
        found |= fits.full([r for r in promising if not r.trial.full])
        found |= refits_with_own_numerics(fits, found)
    found |= _rivals(fits, [t for t in wanted if tuple(e.name for e in t.effects) not in found], found)
    best = best_first(found)[: criteria.search.full]
    passing = [r for r in best if not r.trial.full and r.refit.delta_bic >= criteria.delta_bic]
    close = [r for r in passing if _comes_close(r.refit, best[0].refit, start, criteria)]
    found |= fits.full(close)
    return found | refits_with_own_numerics(fits, found)


def refits_with_own_numerics(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """Full fits that take off most of a misfit, and yet leave some: with the numerical error of their own models. Where
    none does, those that the data ask for and that come close to the best: this is to be known before a second effect
    is looked for, or none is said to explain them, and which is the best may hang on it."""
    start, criteria = fits.start, fits.criteria
    if not start.fitted.parametrisation.numerics.names:
        return {}
    settled = [r for r in best_first(found) if r.trial.full]
    most, least = _left(start, criteria.search.nearly), min((r.trial.excess for r in settled), default=0.0)
    close = [r for r in settled if r.trial.excess < min(most, criteria.search.comparable * least)]
    if not close:
        asked = (r for r in settled if r.refit.delta_bic >= criteria.delta_bic)
        close = [r for r in asked if r.trial.excess < criteria.search.close * least]
    left = [r for r in close if not r.refit.own_numerics and not fits.explains(r.trial)]
    again = fits.full(left, own_numerics=True)
    failing = [r for r in left if not fits.explains(again.get(r.trial.effects, r).trial)]
    return again | _turned_round(fits, failing, again)


def _turned_round(fits: FitContext, fitted: Sequence[FittedCandidate], again: CandidateFits) -> CandidateFits:
    """Likewise from the other sign, where that is better: a coarse mesh may show an effect of the right sign so weakly
    that a fit on it ends at the wrong one."""
    tries = [
        FitTask(r.refit.effects, (), True, near=r.refit.fitted, own_numerics=True, size=-1.0)
        for r in fitted
        if have_two_signs(r.refit.effects)
    ]
    found = fits.results(tries) if tries else {}
    return {names: r for names, r in found.items() if names not in again or r.refit.drop > again[names].refit.drop}


def other_sizes(fits: FitContext, found: CandidateFits) -> CandidateFits:
    """The best effect, where it explains the data, fitted from other sizes too: the best of these fits, which knows of
    those that are as likely."""
    start, criteria = fits.start, fits.criteria
    explain = [r for r in best_first(found) if r.trial.full and not fits.fails(r.trial)]
    if not explain or explain[0].refit.delta_bic < criteria.delta_bic:
        return {}
    first = explain[0].refit
    tries = [FitTask(first.effects, (), True, near=first.fitted, size=size) for size in SIZE_FACTORS]
    tried = fits.runner(start, criteria, tries, reporting(fits.progress))
    some = [explain[0], *(r for r in tried if r is not None)]
    best = max(some, key=lambda r: r.refit.drop)
    also = [r.refit.fitted for r in some if r is not best and as_likely(r.refit.fitted, best.refit.fitted)]
    refit = replace(best.refit, also=tuple(without_branches(f) for f in also), own_numerics=first.own_numerics)
    return {best.trial.effects: replace(best, refit=refit)}


def _left(start: Baseline, share: float) -> float:
    """Mean squared misfit once so much of the misfit is taken off; what the scatter leaves, 1, is none"""
    return 1 + (1 - share) * (start.fitted.compared.mean_squared_misfit - 1)


def _comes_close(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    return one.mean_squared_misfit < criteria.search.close * best.mean_squared_misfit or nearly(
        one, best, start, criteria
    )


def _explaining(fits: FitContext, found: CandidateFits) -> FittedCandidate | None:
    """The best one, if it explains the data, on runs that no fit saw too."""
    best = min(found.values(), key=lambda r: r.trial.excess, default=None)
    return best if best is not None and fits.explains(best.trial) else None


def _rivals(fits: FitContext, left: Sequence[FitTask], found: CandidateFits) -> CandidateFits:
    """Where one explains the data, and they ask for it, the others as they come, two at a time, until neither comes
    close: how likely they look is to first order, and nothing is to be named that was not held against what comes next
    by the score test and by probes, which take turns."""
    best, criteria = _explaining(fits, found), fits.criteria
    if best is None or best.refit.delta_bic < criteria.delta_bic:
        return {}
    rivals: CandidateFits = {}
    for first in range(0, len(left), 2):
        two = fits.results(left[first : first + 2])
        rivals |= two
        if not any(_comes_close(r.refit, best.refit, fits.start, criteria) for r in two.values()):
            break
    return rivals
