"""The search: numerical gate, calibration, score tests, refits of the best, more effects where one is not enough."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.prediction_error import PredictionError, prediction_error
from updamp.comparison.prediction.branch_tasks import BranchesBy
from updamp.diagnosis.candidate_models.baseline import Baseline, farthest_off
from updamp.diagnosis.candidate_models.candidate_fits import CandidateFits, FitContext, Progress
from updamp.diagnosis.candidate_models.fit_tasks import FitRunner, fit_here
from updamp.diagnosis.candidate_models.if_repeatable import if_repeatable
from updamp.diagnosis.candidate_models.if_runs_drift import if_runs_drift
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import EffectScore, Evidence, IfRunsDrift, Trial, gain_over_fewer
from updamp.diagnosis.score_tests.score import Score, cosines, scores
from updamp.diagnosis.score_tests.signature import Extended, extend
from updamp.diagnosis.selection.equal_numerics import with_equal_numerics
from updamp.diagnosis.selection.fair_credit import by_the_same_gate, credited, without_effects_again
from updamp.diagnosis.selection.further_effects import further_effects
from updamp.diagnosis.selection.other_minima import other_sizes
from updamp.diagnosis.selection.other_places import try_other_places
from updamp.diagnosis.selection.pairs import alone, exchanged, try_pairs
from updamp.diagnosis.selection.single_effects import try_singles
from updamp.effects.effect import Effect
from updamp.effects.sized import sized
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """extended: the calibrated model with all effects at null; scored: about the model without effects

    refits: by the names of their effects
    """

    baseline: Baseline
    extended: Extended
    scored: tuple[Score, ...]
    refits: Mapping[tuple[str, ...], Refit]
    evidence: Evidence


def search(
    start: Baseline,
    effects: Sequence[Effect],
    criteria: Criteria,
    progress: Progress = lambda _: None,
    runner: FitRunner = fit_here,
    workers: Workers = here,
) -> SearchResult:
    """runner: where the fits are run; workers: likewise what leads to them

    Begun again from a better calibration where fits with an effect have led to one and all of them fail: scores, probes
    and what was fitted first rest on the calibration.

    raises: BranchStoppedError where the calibrated model has no response at the beginning of a run
    """
    begun = _one_by_one(FitContext(start, criteria, progress, runner, workers), effects)
    without = without_effects_again(begun.fits, begun.singles)
    if without is not None:
        better, trial = without
        if trial.delta_bic >= criteria.delta_bic and all(begun.fits.fails(r.trial) for r in begun.singles.values()):
            progress("a better calibration was found on the way: from there once more")
            return search(replace(better, attempt=start.attempt + 1), effects, criteria, progress, runner, workers)
        fits, held_out, singles, _ = _from(better, trial, begun.fits, begun.held_out, begun.singles, {})
        begun = replace(begun, fits=fits, held_out=held_out, singles=singles)
    return _together(_elsewhere(begun, start, effects))


@dataclass(frozen=True, eq=False)
class _Begun:
    """A search as far as effects one by one: fitting, those that were tried; extended, scored: as in `SearchResult`;
    held_out: of the model without effects; singles: fits of one effect"""

    fits: FitContext
    fitting: Sequence[Effect]
    extended: Extended
    scored: tuple[Score, ...]
    held_out: PredictionError
    singles: CandidateFits


def _one_by_one(fits: FitContext, effects: Sequence[Effect]) -> _Begun:
    start, workers = fits.start, fits.workers
    base, plan = start.fitted, start.train_plan
    fitting = [sized(effect, base.parametrisation.base, plan.largest_amplitude) for effect in effects]
    extended = extend(base, plan, fitting, fits.progress, workers)
    scored = scores(extended)
    held_out = prediction_error(base, start.held_out_plan, BranchesBy(workers))
    singles = try_singles(fits, fitting, scored)
    singles = singles | other_sizes(fits, singles)
    return _Begun(fits, fitting, extended, scored, held_out, singles)


def _elsewhere(begun: _Begun, start: Baseline, effects: Sequence[Effect]) -> _Begun:
    """With effects at other places, where these were tried. start: the model that scores are told about"""
    fits = begun.fits
    if not (elsewhere := try_other_places(fits, effects, begun.singles)):
        return begun
    fitting = [*begun.fitting, *(e for r in elsewhere.values() for e in r.refit.effects)]
    extended = extend(start.fitted, start.train_plan, fitting, fits.progress, fits.workers)
    singles = begun.singles | elsewhere
    return replace(begun, fitting=fitting, extended=extended, scored=scores(extended), singles=singles)


def _together(begun: _Begun) -> SearchResult:
    """Two effects and more, where one is not enough, and what all of it comes to."""
    fits, held_out, singles = begun.fits, begun.held_out, begun.singles
    free = _if_runs_drift(fits, singles)
    several = begun.fitting if free is None or _comes_close(fits, singles, free) else ()
    further, pairs = exchanged(fits, several, singles, try_pairs(fits, several, singles))
    singles = singles | further
    singles = singles | alone(fits, singles, pairs)
    combined = pairs | further_effects(fits, several, singles, pairs)
    singles = singles | with_equal_numerics(fits, singles)
    combined = combined | with_equal_numerics(fits, combined)
    if (without := by_the_same_gate(fits, singles, combined)) is not None:
        fits, held_out, singles, combined = _from(*without, fits, held_out, singles, combined)
    combined = _over_fewer(singles, combined)
    evidence = _evidence(fits, begun.extended, begun.scored, held_out, singles, combined, free)
    refits = {names: r.refit for names, r in {**singles, **combined}.items()}
    return SearchResult(fits.start, begun.extended, begun.scored, refits, evidence)


def _from(
    better: Baseline,
    trial: Trial,
    fits: FitContext,
    held_out: PredictionError,
    singles: CandidateFits,
    combined: CandidateFits,
) -> tuple[FitContext, PredictionError, CandidateFits, CandidateFits]:
    """All that rests on the model without effects, from a better fit of it; trial: what that came to"""
    before, plan = fits.start.fitted, fits.start.train_plan
    singles, combined = (credited(found, before, better.fitted, plan) for found in (singles, combined))
    held_out = replace(held_out, error=trial.held_out, misfit=trial.unseen)
    return replace(fits, start=better), held_out, singles, combined


def _over_fewer(singles: CandidateFits, combined: CandidateFits) -> CandidateFits:
    """Of two effects and more, what they gain over the best model with one of them less, now that all are fitted."""
    gains = {frozenset(names): r.refit.delta_bic for names, r in {**singles, **combined}.items()}
    return {
        names: replace(r, trial=replace(r.trial, delta_bic=gain_over_fewer(frozenset(names), gains)))
        for names, r in combined.items()
    }


def _evidence(
    fits: FitContext,
    extended: Extended,
    scored: Sequence[Score],
    held_out: PredictionError,
    singles: CandidateFits,
    combined: CandidateFits,
    free: IfRunsDrift | None,
) -> Evidence:
    start, base = fits.start, fits.start.fitted
    of_singles, of_combined = (
        tuple(sorted((r.trial for r in each.values()), key=lambda t: t.excess)) for each in (singles, combined)
    )
    farthest, deviations = farthest_off(base)
    return Evidence(
        excess=base.compared.mean_squared_misfit,
        held_out=held_out.error,
        repeatability=start.repeatability,
        tested=_tested(extended, scored),
        trials=of_singles,
        combined=of_combined,
        alike=_alike(scored, fits.criteria),
        farthest=farthest,
        deviations=deviations,
        if_repeatable=if_repeatable(base, start, BranchesBy(fits.workers)),
        independent=start.train_plan.independent,
        unseen=held_out.misfit,
        unseen_independent=held_out.values / start.train_plan.as_one,
        as_one=start.train_plan.as_one,
        noise_freedom=start.plan.noise_freedom,
        stated=start.stated,
        if_runs_drift=free,
        unseen_farthest=held_out.farthest,
        unseen_deviations=held_out.deviations,
    )


def _if_runs_drift(fits: FitContext, singles: CandidateFits) -> IfRunsDrift | None:
    """Of a model that fails while no single effect explains the data, where that would."""
    start, criteria = fits.start, fits.criteria
    failing = criteria.fails(start.fitted.compared.mean_squared_misfit, start.freedom)
    if not failing or any(fits.explains(r.trial) for r in singles.values()):
        return None
    fits.progress("with a resonance of its own for every run")
    free = if_runs_drift(start, BranchesBy(fits.workers))
    if free is None or criteria.fails(free.excess, start.freedom) or criteria.fails(free.unseen, start.unseen_freedom):
        return None
    return free


def _comes_close(fits: FitContext, singles: CandidateFits, free: IfRunsDrift) -> bool:
    """Whether an effect takes off nearly as much as free resonances of the runs do: a second one may do the rest."""
    before = fits.start.fitted.compared.mean_squared_misfit
    least = min((r.trial.excess for r in singles.values()), default=before)
    return before - least > fits.criteria.search.nearly * (before - free.excess)


def _tested(extended: Extended, scored: Sequence[Score]) -> tuple[EffectScore, ...]:
    still = {name: 1e-9 * size for name, size in extended.compared.scatter.parameters.items()}
    stiff = replace(extended.compared.scatter, parameters=still, drift=1e-12, gain=1e-9, level=1e-9, shape=1e-9)
    without = {
        s.effect.name: s.score for s in scores(replace(extended, compared=replace(extended.compared, scatter=stiff)))
    }
    return tuple(
        EffectScore(s.effect.name, s.score, s.visibility, s.drop, s.raw, without.get(s.effect.name, 0.0))
        for s in scored
    )


def _alike(scored: Sequence[Score], criteria: Criteria) -> tuple[tuple[str, str, float], ...]:
    matrix = np.abs(cosines(scored))
    return tuple(
        (scored[i].effect.name, scored[j].effect.name, float(matrix[i, j]))
        for i in range(len(scored))
        for j in range(i)
        if matrix[i, j] > criteria.cosine
    )
