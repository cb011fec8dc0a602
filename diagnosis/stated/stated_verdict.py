"""From the explanations of stated frequencies to the verdict, and to the table for the terminal.

A few numbers cannot confirm an effect: nothing is held out, so none is ever identified. Where nuisance parameters that
can be believed meet them too, the data do not even ask for one.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from updamp.comparison.comparison import Calibrated
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.stated.stated_explanations import MET, Explanation, Explanations, LowForceProblem
from updamp.diagnosis.stated.stated_predictions import (
    MeasurableQuantity,
    StatedPrediction,
    SurvivingExplanation,
    separating,
)
from updamp.diagnosis.stated.stated_score import StatedScore
from updamp.diagnosis.verdict import Candidate, Confounding, ErrorReached, FittedParameter, Outcome, Step, Verdict
from updamp.effects.effect import Effect

# Share of what calibration leaves, priors included, that an effect may leave if it is to count as the cause.
_LEFT = 0.5
_95 = 1.96
# Hertz's: stiffness of the contacts against load, where that is the cause.
HERTZ = 1 / 3


def verdict_of(
    problem: LowForceProblem,
    found: Explanations,
    scored: Mapping[str, StatedScore],
    effects: Sequence[Effect],
    predictions: Sequence[StatedPrediction],
    wanted: Sequence[MeasurableQuantity],
    criteria: Criteria,
    provenance: Mapping[str, str],
) -> Verdict:
    """predictions: of `survivors_of(found)`, of the quantities `wanted`; criteria: what looks alike"""
    outcome, group = decided(found)
    accepted = _accepted(found)
    best = min((found.helped[name] for name in accepted), key=lambda e: e.chi2, default=found.calibrated)
    nan, n = float("nan"), len(problem.features)
    before, after = (float(np.sqrt(e.chi2 / n)) for e in (found.as_given, best))
    return Verdict(
        verdict=outcome,
        sentence=_sentence(outcome, found),
        effects=best.effects if outcome == "inseparable" else (),
        group=group,
        candidates=_candidates(found, scored, effects),
        error=ErrorReached(before, after, nan, nan, 1.0),
        next_measurement=separating(predictions, wanted),
        signatures=(),
        confounding=Confounding(tuple(scored), _cosines(scored), criteria.cosine, _alike(scored, criteria)),
        missing_forces=(),
        history=(Step((), before, nan),),
        provenance=provenance,
        calibration=_calibration(best),
    )


def decided(found: Explanations) -> tuple[Outcome, tuple[str, ...]]:
    """The outcome, and the names of what meets the stated values with one thing changed."""
    if found.as_given.met:
        return "adequate", ()
    alone, accepted = tuple(e.name for e in found.single if e.met), _accepted(found)
    if found.calibrated.met:
        return "undecidable", (*alone, *accepted)
    if accepted:
        return "inseparable", accepted
    return ("undecidable" if any(e.met for e in found.pairs) else "unknown"), ()


def survivors_of(found: Explanations) -> tuple[SurvivingExplanation, ...]:
    """The surviving explanations: of contact stiffness also that it comes from the pressure."""
    survivors: list[SurvivingExplanation] = []
    if found.as_given.met:
        return ()
    for e in (e for e in found.single if e.met):
        survivors.append(SurvivingExplanation(e.name, e))
        if e.name in ("normal_stiffness", "contact_stiffness"):
            survivors.append(SurvivingExplanation(f"{e.name} by pressure", e, HERTZ))
    if not survivors and found.calibrated.met:
        survivors.append(SurvivingExplanation("calibration", found.calibrated))
    for name in _accepted(found):
        fit = found.alone[name] if found.alone[name].met else found.helped[name]
        survivors.append(SurvivingExplanation(fit.name, fit))
    return tuple(survivors)


def _accepted(found: Explanations) -> tuple[str, ...]:
    return tuple(name for name in found.helped if not why_not_the_cause(found, name))


def why_not_the_cause(found: Explanations, name: str) -> str:
    """Why an effect that moves a stated value is not taken to be the cause, "" if it is."""
    alone, helped = found.alone[name], found.helped[name]
    if not helped.met:
        return f"it leaves {worst(helped)} even with calibration"
    if alone.met or helped.chi2 < _LEFT * found.calibrated.chi2:
        return ""
    return f"alone it leaves {worst(alone)}; calibration does the rest, and does as well without it"


def worst(e: Explanation) -> str:
    """The stated value that is missed most, and nuisance parameters that cannot be believed."""
    i = int(np.argmax(np.abs(e.off)))
    missed = f"a frequency {abs(e.off[i]):.3g} standard deviations {'high' if e.off[i] > 0 else 'low'}"
    if abs(e.off[i]) <= MET:
        deviation = e.parametrisation.deviation
        n = len(e.parametrisation.nuisances)
        j = int(np.argmax(np.abs(e.u[:n]) / deviation[:n]))
        name = e.parametrisation.names[j]
        missed = f"{name} at {np.exp(e.u[j]):.3g} times the rig file's"
    return missed


def _sentence(outcome: Outcome, found: Explanations) -> str:
    if outcome == "adequate":
        return "nothing is missing that the stated values could show"
    if outcome == "unknown":
        return (
            f"no effect and no two effects meet the stated values; calibration alone leaves {worst(found.calibrated)}"
        )
    accepted = _accepted(found)
    if outcome == "inseparable":
        which = f"one of {', '.join(accepted)}" if len(accepted) > 1 else accepted[0]
        return f"{which} could be missing; stated values alone, none of them held out, do not confirm it"
    pairs = sum(e.met for e in found.pairs)
    if not found.calibrated.met:
        return f"no single effect meets the stated values, {pairs} pairs do; so few values do not tell which"
    alone = [f"{e.name} at {next(iter(e.factors.values())):.3g} times the rig file's" for e in found.single if e.met]
    sentence = f"the stated values do not ask for an effect: {' or '.join(alone) or 'calibration'} meets all of them"
    also = f", so would {', '.join(accepted)}" if accepted else ""
    return sentence + also + (f", and {pairs} pairs of effects" if pairs else "")


def _candidates(
    found: Explanations, scored: Mapping[str, StatedScore], effects: Sequence[Effect]
) -> tuple[Candidate, ...]:
    listed = [
        _fitted(effect, found, scored[effect.name]) if effect.name in found.helped else _not_fitted(effect, found)
        for effect in effects
    ]
    return tuple(sorted(listed, key=lambda c: (not c.accepted, -c.obtained_drop if c.obtained_drop > 0 else 0.0)))


def _fitted(effect: Effect, found: Explanations, score: StatedScore) -> Candidate:
    alone, helped = found.alone[effect.name], found.helped[effect.name]
    reason = why_not_the_cause(found, effect.name)
    drop = found.calibrated.chi2 - helped.chi2
    return Candidate(
        name=effect.name,
        sentence=effect.sentence,
        score=score.score,
        visibility=score.visibility,
        predicted_drop=score.score**2,
        obtained_drop=drop,
        delta_bic=drop - len(effect.parameters) * float(np.log(len(helped.off))),
        held_out_gain=float("nan"),
        parameters=_parameters(alone if alone.met else helped),
        accepted=not reason,
        reason=reason,
    )


def _not_fitted(effect: Effect, found: Explanations) -> Candidate:
    nan = float("nan")
    return Candidate(
        name=effect.name,
        sentence=effect.sentence,
        score=0.0,
        visibility=0.0,
        predicted_drop=0.0,
        obtained_drop=nan,
        delta_bic=nan,
        held_out_gain=nan,
        parameters=(),
        accepted=False,
        reason=found.without_place.get(effect.name, "it does not move a resonance at small force"),
    )


def _parameters(fit: Explanation) -> tuple[FittedParameter, ...]:
    (effect,), n = fit.parametrisation.effects, len(fit.parametrisation.nuisances)
    values, found = fit.parametrisation.values(fit.u)[effect.name], []
    for i, p in enumerate(effect.parameters):
        half = _95 * float(np.sqrt(fit.covariance[n + i, n + i])) * abs(p.typical - p.null)
        value = values[p.name]
        others = [fit.parametrisation.values(u)[effect.name][p.name] for u in fit.as_good]
        lower, upper = max(min([value - half, *others]), p.lower), min(max([value + half, *others]), p.upper)
        found.append(FittedParameter(p.name, p.unit, value, lower, upper, p.null, p.lower, p.upper))
    return tuple(found)


def _calibration(fit: Explanation) -> tuple[Calibrated, ...]:
    deviations, entries = np.sqrt(np.diag(fit.covariance)), []
    for n, u, s in zip(fit.parametrisation.nuisances, fit.u, deviations, strict=False):
        after, lower, upper = (float(np.exp(u + z * s)) for z in (0.0, -_95, _95))
        entries.append(Calibrated(n.name, "", 1.0, n.deviation, after, lower, upper))
    return tuple(entries)


def _cosines(scored: Mapping[str, StatedScore]) -> np.ndarray:
    directions = np.array([s.direction for s in scored.values()])
    return np.asarray(directions @ directions.T) if len(scored) else np.zeros((0, 0))


def _alike(scored: Mapping[str, StatedScore], criteria: Criteria) -> tuple[tuple[str, ...], ...]:
    names, cosine = tuple(scored), np.abs(_cosines(scored))
    return tuple((names[i], names[j]) for i, j in zip(*np.nonzero(np.triu(cosine, 1) > criteria.cosine), strict=True))
