"""The search: numerical gate, calibration, score tests, refits of the best, pairs where one effect is not enough."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.search.attempts import Attempt, Bench, Done, Result, run_here, with_branches, without_branches
from updamp.diagnosis.search.baseline import Baseline, error_of
from updamp.diagnosis.search.candidates import attempts
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.evidence import EffectScore, Evidence, Trial
from updamp.diagnosis.search.refit import Refit, gain_of_bic, judged
from updamp.diagnosis.search.resized import SIZES, as_likely, have_two_signs
from updamp.diagnosis.search.score import Score, cosines, scores
from updamp.diagnosis.search.signature import Extended, extend

Floats = NDArray[np.float64]
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Found:
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
    bench: Bench = run_here,
) -> Found:
    """bench: where the fits are run

    raises: BranchStoppedError where the calibrated model has no response at the beginning of a run
    """
    base, plan = start.fitted, start.train_plan
    extended = extend(base, plan, effects, progress)
    scored = scores(extended)
    held_out = error_of(base, start.held_out_plan)
    fits = _Fits(start, criteria, progress, bench)
    singles = _singles(fits, effects, scored)
    singles |= _other_sizes(fits, singles)
    pairs = _pairs(fits, effects, singles)
    singles |= _alone(fits, singles, pairs)
    evidence = Evidence(
        base.compared.excess,
        held_out,
        start.repeatability,
        _tested(extended, scored),
        tuple(sorted((r.trial for r in singles.values()), key=lambda t: t.excess)),
        tuple(sorted((r.trial for r in pairs.values()), key=lambda t: t.excess)),
        _alike(scored, criteria),
    )
    refits = {names: r.refit for names, r in {**singles, **pairs}.items()}
    return Found(start, extended, scored, refits, evidence)


Results = dict[tuple[str, ...], Result]


@dataclass(frozen=True, eq=False)
class _Fits:
    """Of a search: where they start, what they are judged by, who is told, and where they are run."""

    start: Baseline
    criteria: Criteria
    progress: Progress
    bench: Bench

    def results(self, attempts: Sequence[Attempt]) -> Results:
        found = self.bench(self.start, self.criteria, attempts, _telling(self.progress))
        return {r.trial.effects: r for r in found if r is not None}

    def full(self, some: Sequence[Result], gated_again: bool = False) -> Results:
        return self.results(
            [Attempt(r.refit.effects, (), True, near=r.refit.fitted, gated_again=gated_again) for r in some]
        )


def _singles(fits: _Fits, effects: Sequence[Effect], scored: Sequence[Score]) -> Results:
    """Short refits of those that look most likely, full ones of the best."""
    start, criteria = fits.start, fits.criteria
    wanted = attempts(start, effects, scored, criteria, fits.progress)[: criteria.short]
    half = (len(wanted) + 1) // 2
    found = fits.results(wanted[:half])
    enough = criteria.promising * start.fitted.compared.excess
    found |= fits.full([r for r in _best(found)[:1] if r.trial.excess < enough])
    found |= _gated_again(fits, found)
    found |= fits.results(_unless_explained(wanted[half:], found, scored, criteria))
    best = _best(found)[: criteria.full]
    asked_for = [r for r in best if not r.trial.full and r.refit.delta_bic >= criteria.delta_bic]
    close = [r for r in asked_for if _comes_close(r.refit, best[0].refit, start, criteria)]
    found |= fits.full(close)
    return found | _gated_again(fits, found)


def _gated_again(fits: _Fits, found: Results) -> Results:
    """Full fits that take off most of a misfit, and yet leave some: with the numerical error of their own models."""
    start, criteria = fits.start, fits.criteria
    if not start.fitted.parametrisation.numerics.names:
        return {}
    settled = [r for r in _best(found) if r.trial.full]
    # what the scatter leaves, chi2 of 1 a value, is no misfit
    most = 1 + (1 - criteria.nearly) * (start.fitted.compared.excess - 1)
    least = min((r.trial.excess for r in settled), default=0.0)
    close = [r for r in settled if r.trial.excess < min(most, criteria.comparable * least)]
    left = [r for r in close if not r.refit.gated_again and not _explains(r.trial, criteria)]
    again = fits.full(left, gated_again=True)
    return again | _turned_round(fits, left, again)


def _turned_round(fits: _Fits, fitted: Sequence[Result], again: Results) -> Results:
    """Likewise from the other sign, where that is better: a coarse mesh may show an effect of the right sign so weakly
    that a fit on it ends at the wrong one."""
    tries = [
        Attempt(r.refit.effects, (), True, near=r.refit.fitted, gated_again=True, size=-1.0)
        for r in fitted
        if have_two_signs(r.refit.effects)
    ]
    found = fits.results(tries) if tries else {}
    return {names: r for names, r in found.items() if names not in again or r.refit.drop > again[names].refit.drop}


def _other_sizes(fits: _Fits, singles: Results) -> Results:
    """The best effect, where it explains the data, fitted from other sizes too: the best of these fits, which knows of
    those that are as likely."""
    start, criteria = fits.start, fits.criteria
    explain = [r for r in _best(singles) if r.trial.full and r.trial.excess <= criteria.excess]
    if not explain or explain[0].refit.delta_bic < criteria.delta_bic:
        return {}
    first = explain[0].refit
    tries = [Attempt(first.effects, (), True, near=first.fitted, size=size) for size in SIZES]
    tried = fits.bench(start, criteria, tries, _telling(fits.progress))
    some = [explain[0], *(r for r in tried if r is not None)]
    best = max(some, key=lambda r: r.refit.drop)
    also = [r.refit.fitted for r in some if r is not best and as_likely(r.refit.fitted, best.refit.fitted)]
    refit = replace(best.refit, also=tuple(without_branches(f) for f in also), gated_again=first.gated_again)
    return {best.trial.effects: replace(best, refit=refit)}


def _best(found: Results) -> list[Result]:
    return sorted(found.values(), key=lambda r: -r.refit.drop)


def _comes_close(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    return one.excess < criteria.close * best.excess or _nearly(one, best, start, criteria)


def _unless_explained(
    some: Sequence[Attempt], found: Results, scored: Sequence[Score], criteria: Criteria
) -> Sequence[Attempt]:
    """All of them as long as none before explains a misfit, on runs that no fit saw too; then only those that look like
    it."""
    best = min(found.values(), key=lambda r: r.trial.excess, default=None)
    if best is None or not _explains(best.trial, criteria):
        return some
    if best.refit.delta_bic < criteria.delta_bic:
        return ()  # the data ask for none of the best, as where nothing is missing
    matrix, names = np.abs(cosines(scored)), [s.effect.name for s in scored]
    alike = matrix[names.index(best.trial.effects[0])]
    return [a for a in some if alike[names.index(a.effects[0].name)] > criteria.cosine_of_rivals]


def _explains(trial: Trial, criteria: Criteria) -> bool:
    fails_elsewhere = trial.held_out**2 > criteria.look_further  # nan: there are none
    return trial.excess <= criteria.look_further and not fails_elsewhere


def _telling(progress: Progress) -> Done:
    def done(attempt: Attempt, result: Result | None) -> None:
        left = "no response" if result is None else f"leaves {result.trial.excess**0.5:.2f} times the scatter"
        progress(f"{attempt.name}: {left}")

    return done


def _pairs(fits: _Fits, effects: Sequence[Effect], singles: Results) -> Results:
    """Second effects beside the best single one, where that leaves a misfit, and beside the next one where it explains
    nearly as much: with a second effect beside them the two may change places."""
    start, criteria = fits.start, fits.criteria
    settled = sorted((r.refit for r in singles.values() if r.trial.full), key=lambda r: -r.drop)
    if not settled or settled[0].drop <= 0 or settled[0].excess < criteria.look_further:
        return {}
    found: Results = {}
    for first in (settled[0], *(r for r in settled[1:2] if _nearly(r, settled[0], start, criteria))):
        for names, result in _beside(fits, first, effects, singles).items():
            other_way = found.get(names[::-1])
            if other_way is None or result.refit.drop > other_way.refit.drop:
                found.pop(names[::-1], None)
                found[names] = result
    return found


def _alone(fits: _Fits, singles: Results, pairs: Results) -> Results:
    """Second effects that have not been tried alone, where one explains the data together with a first: it may be all
    that is missing, and the first one a wrong guess that has become small beside it."""
    best = min(pairs.values(), key=lambda r: r.trial.excess, default=None)
    if best is None or best.trial.excess > fits.criteria.excess:
        return {}
    second, fitted = best.refit.effects[1], best.refit.fitted
    if (second.name,) in singles:
        return {}
    start = fitted.u[fitted.parametrisation.columns(second.name)]
    found = fits.results([Attempt((second,), (start,), full=True, as_given=(start,))])
    return found | _gated_again(fits, found)


def _nearly(one: Refit, best: Refit, start: Baseline, criteria: Criteria) -> bool:
    """Whether it takes off nearly as much of chi2 as the best one."""
    before = start.fitted.compared.excess
    comparable = one.excess < criteria.comparable * best.excess
    return comparable and before - one.excess > criteria.nearly * (before - best.excess)


def _beside(fits: _Fits, first: Refit, effects: Sequence[Effect], singles: Results) -> Results:
    (one,), start, criteria = first.effects, fits.start, fits.criteria
    fits.progress(f"second effect beside {one.name}")
    beside = replace(start, fitted=with_branches(first.fitted, start))
    others = [e for e in effects if e.name != one.name]
    again = scores(extend(beside.fitted, start.train_plan, others, fits.progress))
    seconds = attempts(beside, others, again, criteria, fits.progress)[: criteria.full]
    found: Results = {}
    for r in replace(fits, start=beside).results([replace(a, full=True) for a in seconds]).values():
        (second,) = r.refit.effects
        both = judged(start.fitted, r.refit.fitted, (one, second), criteria)
        names = (one.name, second.name)
        trial = replace(r.trial, effects=names, drop=both.drop, delta_bic=_against_parts(start, both, singles))
        found[names] = Result(both, trial)
    return found


def _against_parts(start: Baseline, pair: Refit, singles: Results) -> float:
    """BIC gained over the better one of its two effects."""
    alone = [singles[(e.name,)].refit.drop for e in pair.effects if (e.name,) in singles]
    fewest, values = min(len(e.parameters) for e in pair.effects), start.fitted.compared.values
    return gain_of_bic(pair.drop - max(alone, default=0.0), fewest, values)


def _tested(extended: Extended, scored: Sequence[Score]) -> tuple[EffectScore, ...]:
    still = {name: 1e-9 * size for name, size in extended.compared.scatter.parameters.items()}
    stiff = replace(extended.compared.scatter, parameters=still, drift=1e-12, gain=1e-9)
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
