"""One effect more beside those that have been fitted."""

from collections.abc import Sequence
from dataclasses import replace

from updamp.comparison.prediction.branch_tasks import BranchesBy
from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate, with_branches
from updamp.diagnosis.candidate_models.refit import Refit, assessed
from updamp.diagnosis.evidence import gain_over_fewer
from updamp.diagnosis.score_tests.score import scores
from updamp.diagnosis.score_tests.signature import extend
from updamp.diagnosis.selection.single_effects import refits_with_own_numerics, try_singles
from updamp.effects.effect import Effect


def beside(fits: FitContext, first: Refit, effects: Sequence[Effect], fewer: CandidateFits) -> CandidateFits:
    """Fits with the effects of `first` and each of the others. fewer: fits with one effect less, to be better than"""
    start, criteria = fits.start, fits.criteria
    there = {e.kind for e in first.effects}
    fits.progress(f"another effect beside {' and '.join(e.name for e in first.effects)}")
    about = replace(fits, start=replace(start, fitted=with_branches(first.fitted, start, BranchesBy(fits.workers))))
    others = [e for e in effects if e.kind not in there]
    again = scores(extend(about.start.fitted, start.train_plan, others, fits.progress, fits.workers))
    tried = try_singles(about, others, again)
    settled = {names: r for names, r in tried.items() if r.trial.full}
    if start.fitted.parametrisation.base.contacts is None:
        settled |= refits_with_own_numerics(about, settled)
    known = {frozenset(some): one.refit.delta_bic for some, one in fewer.items()}
    found: CandidateFits = {}
    for r in settled.values():
        whole = assessed(start.fitted, r.refit.fitted, start.train_plan, (*first.effects, *r.refit.effects), criteria)
        together = replace(whole, own_numerics=r.refit.own_numerics)
        names = tuple(e.name for e in together.effects)
        parameters = sum(len(e.parameters) for e in together.effects)
        gain = gain_over_fewer(frozenset(names), known | {frozenset(names): together.delta_bic})
        trial = replace(r.trial, effects=names, drop=together.drop, delta_bic=gain, parameters=parameters)
        found[names] = FittedCandidate(together, trial)
    return found
