"""The search: numerical gate, calibration, score tests, refits of the best, pairs where one effect is not enough."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.residual.fit import Fit
from updamp.diagnosis.search.baseline import Baseline, error_of
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.evidence import Evidence, Tested, Trial
from updamp.diagnosis.search.refit import Refit, judged, refit
from updamp.diagnosis.search.score import Score, cosines, scores
from updamp.diagnosis.search.signature import Extended, extend

Floats = NDArray[np.float64]
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Found:
    """extended: the calibrated model with all effects at null; scored: about the model without effects

    refits: by the names of their effects; refused: effects that the model has no place for, and why
    """

    baseline: Baseline
    extended: Extended
    scored: tuple[Score, ...]
    refits: Mapping[tuple[str, ...], Refit]
    evidence: Evidence
    refused: Mapping[str, str]


def search(
    start: Baseline, effects: Sequence[Effect], criteria: Criteria, progress: Progress = lambda _: None
) -> Found:
    """raises: BranchStoppedError where the calibrated model has no response at the beginning of a run"""
    base, plan = start.fitted, start.train_plan
    extended = extend(base, plan, effects, progress)
    scored = scores(extended)
    held_out = error_of(base, start.held_out_plan)
    singles = _singles(start, scored, criteria, progress)
    trials = {names: _trial(start, r, r.delta_bic, full) for names, (r, full) in singles.items()}
    pairs = _pairs(start, effects, singles, criteria, progress)
    of_pairs = {names: _trial(start, r, _against_parts(r, names, singles, base), True) for names, r in pairs.items()}
    evidence = Evidence(
        base.compared.chi2 / base.compared.values,
        held_out,
        start.repeatability,
        _tested(extended, scored),
        tuple(sorted(trials.values(), key=lambda t: t.excess)),
        tuple(sorted(of_pairs.values(), key=lambda t: t.excess)),
        _alike(scored, criteria),
    )
    refits = {**{names: r for names, (r, _) in singles.items()}, **pairs}
    return Found(start, extended, scored, refits, evidence, extended.refused)


def _singles(
    start: Baseline, scored: Sequence[Score], criteria: Criteria, progress: Progress
) -> dict[tuple[str, ...], tuple[Refit, bool]]:
    """Short refits of those that the score test does not rule out, full ones of the best."""
    base, plan = start.fitted, start.train_plan
    found: dict[tuple[str, ...], Refit] = {}
    wanted = [s for s in scored if s.score >= criteria.score and s.visibility >= criteria.visibility][: criteria.short]
    for s in wanted:
        progress(f"refit {s.effect.name}")
        r = refit(base, plan, [s.effect], _starts(s.step), criteria, full=False)
        if r is not None:
            found[(s.effect.name,)] = r
    best = sorted(found, key=lambda names: -found[names].drop)[: criteria.full]
    result = {names: (r, False) for names, r in found.items()}
    for names in best:
        progress(f"full refit {names[0]}")
        again = refit(base, plan, found[names].effects, (), criteria, full=True, near=found[names].fitted)
        if again is not None:
            result[names] = (again, True)
    return result


def _starts(step: Floats) -> tuple[Floats, ...]:
    """The linear guess, no further than the typical size, and a third of it."""
    size = max(1.0, float(np.max(np.abs(step))))
    return step / size, step / size / 3


def _pairs(
    start: Baseline,
    effects: Sequence[Effect],
    singles: Mapping[tuple[str, ...], tuple[Refit, bool]],
    criteria: Criteria,
    progress: Progress,
) -> dict[tuple[str, ...], Refit]:
    """Second effects beside the best single one, where that leaves a misfit."""
    full = sorted((r for r, whole in singles.values() if whole), key=lambda r: -r.drop)
    found: dict[tuple[str, ...], Refit] = {}
    for first in full[:1]:
        if first.excess < criteria.look_further or first.drop <= 0:
            continue
        (one,) = first.effects
        others = [e for e in effects if e.name != one.name]
        progress(f"second effect beside {one.name}")
        again = scores(extend(first.fitted, start.train_plan, others, progress))
        seconds = [s for s in again if s.score >= criteria.score and s.visibility >= criteria.visibility]
        for s in seconds[: criteria.full]:
            progress(f"pair {one.name}, {s.effect.name}")
            r = refit(first.fitted, start.train_plan, [s.effect], _starts(s.step), criteria, full=True)
            if r is not None:
                both = judged(start.fitted, r.fitted, (one, s.effect), criteria)
                found[(one.name, s.effect.name)] = replace(both, delta_bic=r.delta_bic)
    return found


def _against_parts(
    pair: Refit, names: tuple[str, ...], singles: Mapping[tuple[str, ...], tuple[Refit, bool]], base: Fit
) -> float:
    """BIC gained over the better one of its effects alone; over the first where the second was not fitted alone."""
    alone = [singles[(name,)][0].drop for name in names if (name,) in singles]
    noise = max(1.0, pair.excess)
    fewest = min(len(e.parameters) for e in pair.effects)
    return (pair.drop - max(alone, default=0.0)) / noise - fewest * float(np.log(base.compared.values))


def _trial(start: Baseline, r: Refit, delta_bic: float, full: bool) -> Trial:
    held_out = error_of(r.fitted, start.held_out_plan)
    return Trial(tuple(e.name for e in r.effects), r.excess, r.drop, delta_bic, held_out, r.at_bound, full)


def _tested(extended: Extended, scored: Sequence[Score]) -> tuple[Tested, ...]:
    still = {name: 1e-9 * size for name, size in extended.compared.scatter.parameters.items()}
    stiff = replace(extended.compared.scatter, parameters=still, drift=1e-12, gain=1e-9)
    without = {
        s.effect.name: s.score for s in scores(replace(extended, compared=replace(extended.compared, scatter=stiff)))
    }
    return tuple(
        Tested(s.effect.name, s.score, s.visibility, s.drop, s.raw, without.get(s.effect.name, 0.0)) for s in scored
    )


def _alike(scored: Sequence[Score], criteria: Criteria) -> tuple[tuple[str, str, float], ...]:
    matrix = np.abs(cosines(scored))
    return tuple(
        (scored[i].effect.name, scored[j].effect.name, float(matrix[i, j]))
        for i in range(len(scored))
        for j in range(i)
        if matrix[i, j] > criteria.cosine
    )
