"""What an effect is credited with: the fall of the misfit from the model without it, as well fitted as the one with.

Fits with an effect go on from several starts and pass the numerical gate once more; a calibration that has stopped
short of its optimum would hand all of that to the first effect whose fit moves.
"""

from collections.abc import Mapping
from dataclasses import replace

from updamp.comparison.fit.compared import misfit
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.branch_tasks import BranchesBy
from updamp.diagnosis.candidate_models.baseline import Baseline, calibrated_as
from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, best_first
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, FittedCandidate, with_branches
from updamp.diagnosis.candidate_models.refit import gain_of_bic
from updamp.diagnosis.evidence import Trial

Names = tuple[str, ...]


def without_effects_again(fits: FitContext, found: CandidateFits) -> tuple[Baseline, Trial] | None:
    """The model without effects fitted once more, from the calibration of the best one with an effect and with the same
    numerical gate, unless it fails by more than any; None where it comes to nothing better, or the data ask for no
    effect anyway."""
    start, criteria = fits.start, fits.criteria
    settled = [r for r in best_first(found) if r.trial.full and r.refit.delta_bic >= criteria.delta_bic]
    if not settled:
        return None
    best = settled[0].refit
    u = calibrated_as(start.fitted, best.fitted)
    there = replace(start.fitted, compared=replace(start.fitted.compared, u=u, branches=()))
    again, own = _from_there(fits, there, best.own_numerics)
    if again is None or again.refit.drop <= 0:
        return None
    fitted = with_branches(again.refit.fitted, start, BranchesBy(fits.workers))
    return replace(start, fitted=fitted, own_numerics=start.own_numerics or own), again.trial


def _from_there(fits: FitContext, there: Fit, own: bool) -> tuple[FittedCandidate | None, bool]:
    """The fit without effects, and whether it has the numerical error of its own: if wanted, unless it fails by more
    than any."""
    again = fits.results([FitTask((), (), True, near=there)]).get(())
    if again is None or not own or again.trial.excess > _most_by_numerics(fits):
        return again, False
    return fits.full([again], own_numerics=True).get((), again), True


def _most_by_numerics(fits: FitContext) -> float:
    """Mean squared misfit that numerical error may make of what is within the scatter: of as many deviations as anybody
    would believe of a calibrated value."""
    believed = fits.criteria.calibration(fits.start.stated)
    return 1 + believed**2 * fits.start.fitted.numerics_beside_noise


def by_the_same_gate(fits: FitContext, *found: CandidateFits) -> tuple[Baseline, Trial] | None:
    """Likewise, once fits with effects have the numerical error of their own models, unless the one without has."""
    if fits.start.own_numerics:
        return None
    passed = {names: r for some in found for names, r in some.items() if r.refit.own_numerics}
    return without_effects_again(fits, passed)


def credited(found: Mapping[Names, FittedCandidate], before: Fit, without: Fit, plan: Plan) -> CandidateFits:
    """Effects against the better model without them; before: the one that they were compared with"""
    less = misfit(before.parametrisation, before.compared) - misfit(without.parametrisation, without.compared)
    return {names: _credited(r, less, plan) for names, r in found.items()}


def _credited(one: FittedCandidate, less: float, plan: Plan) -> FittedCandidate:
    drop = one.refit.drop - less
    parameters = sum(len(e.parameters) for e in one.refit.effects)
    gain = gain_of_bic(drop, parameters, plan.independent, plan.as_one)
    refit = replace(one.refit, drop=drop, delta_bic=gain)
    return replace(one, refit=refit, trial=replace(one.trial, drop=drop, delta_bic=gain))
