"""From what the search has found to the verdict that is handed on."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.compare import calibrated_factors
from updamp.comparison.fit.repeat_scatter import scatter_of_repeats
from updamp.diagnosis.candidate_models.baseline import unseen
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import Decision, not_identifiable, reason_against, still_fails
from updamp.diagnosis.decision.explanations import explanations
from updamp.diagnosis.decision.fitted_parameters import fitted_parameters
from updamp.diagnosis.decision.sentence import Wording, sentence
from updamp.diagnosis.decision.signature_curves import signatures
from updamp.diagnosis.decision.verdict_strip import strip
from updamp.diagnosis.evidence import EffectScore, Trial
from updamp.diagnosis.score_tests.score import cosines
from updamp.diagnosis.selection.search import SearchResult
from updamp.diagnosis.verdict import (
    Candidate,
    Confounding,
    ErrorReached,
    FittedEffect,
    MissingForce,
    NextMeasurement,
    Step,
    Verdict,
)

Floats = NDArray[np.float64]
_LESS_WELL = "would explain it too, less well"
_LEAVES_MORE = "takes off some of it, and leaves more than chance can"


def conclude(
    found: SearchResult,
    decision: Decision,
    criteria: Criteria,
    names: Mapping[str, str],
    forces: Sequence[MissingForce] = (),
    provenance: Mapping[str, str] | None = None,
    next_measurement: Sequence[NextMeasurement] = (),
) -> Verdict:
    """names: point of the model -> its channel"""
    chosen = found.refits.get(decision.trial.effects) if decision.trial is not None else None
    candidates = _candidates(found, decision, criteria)
    return Verdict(
        verdict=decision.outcome,
        sentence=sentence(decision, found.evidence, criteria, _words(found, candidates)),
        effects=decision.effects,
        group=decision.group,
        candidates=candidates,
        error=_error(found, decision.trial),
        next_measurement=tuple(next_measurement),
        signatures=signatures(found, names),
        confounding=_confounding(found, criteria),
        missing_forces=tuple(forces),
        history=_history(found, decision),
        provenance=provenance or {},
        calibration=calibrated_factors(chosen.fitted if chosen is not None else found.baseline.fitted),
        strip=strip(found.evidence, criteria),
        explanations=explanations(found.evidence, _fitted(found)),
    )


def _candidates(found: SearchResult, decision: Decision, criteria: Criteria) -> tuple[Candidate, ...]:
    listed = []
    for tested in found.evidence.tested:
        name = tested.effect
        # parameters of effects that are missing together are those of the fit with both
        joint = decision.trial.effects if decision.trial is not None and name in decision.trial.effects else (name,)
        candidate = _candidate(found, tested, found.evidence.trial_of(joint), found.refits.get(joint), criteria)
        named = (*decision.effects, *decision.group)
        if candidate.accepted and named and name not in named:
            trial = found.evidence.trial_of(joint)
            fails = trial is not None and still_fails(trial, found.evidence, criteria)
            candidate = replace(candidate, accepted=False, reason=_LEAVES_MORE if fails else _LESS_WELL)
        listed.append(candidate)
    return tuple(sorted(listed, key=lambda c: -c.obtained_drop if np.isfinite(c.obtained_drop) else -c.predicted_drop))


def _candidate(
    found: SearchResult, tested: EffectScore, trial: Trial | None, fitted: Refit | None, criteria: Criteria
) -> Candidate:
    effect = next(s.effect for s in found.scored if s.effect.name == tested.effect)
    nan = float("nan")
    if trial is None or fitted is None:
        reason = _not_fitted(tested, criteria)
        return Candidate(
            name=effect.name,
            sentence=effect.in_words,
            score=tested.score,
            visibility=tested.visibility,
            predicted_drop=tested.drop,
            obtained_drop=nan,
            delta_bic=nan,
            held_out_gain=nan,
            parameters=(),
            accepted=False,
            reason=reason,
        )
    reason = reason_against(trial, found.evidence, criteria)
    gain = 1 - trial.held_out / found.evidence.held_out if found.evidence.held_out > 0 else nan
    return Candidate(
        name=effect.name,
        sentence=effect.in_words,
        score=tested.score,
        visibility=tested.visibility,
        predicted_drop=tested.drop,
        obtained_drop=trial.drop,
        delta_bic=trial.delta_bic,
        held_out_gain=gain,
        parameters=fitted_parameters(fitted, effect),
        accepted=not reason,
        reason=reason,
    )


def _fitted(found: SearchResult) -> dict[tuple[str, ...], tuple[FittedEffect, ...]]:
    """Values of all effects of every fit that was left to settle."""
    return {
        names: tuple(FittedEffect(e.name, fitted_parameters(refit, e)) for e in refit.fitted.parametrisation.effects)
        for names, refit in found.refits.items()
        if (trial := found.evidence.trial_of(names)) is not None and trial.full
    }


def _not_fitted(tested: EffectScore, criteria: Criteria) -> str:
    if tested.score < criteria.search.score:
        hidden = tested.visibility < criteria.visibility
        return not_identifiable(tested.visibility) if hidden else "the score test sees nothing of it"
    return "others explain more; it was not fitted, or the model with it has no response"


def _error(found: SearchResult, trial: Trial | None) -> ErrorReached:
    before, held = float(np.sqrt(found.evidence.excess)), found.evidence.held_out
    alone = len(found.baseline.train_plan.repeats) == 1
    if trial is None or alone:
        after, unseen_after = (before, held) if trial is None else (float(np.sqrt(trial.excess)), trial.held_out)
        repeatability = float("nan") if alone else found.evidence.repeatability
        return ErrorReached(before, after, held, unseen_after, repeatability)
    # what a misfit leaves in the differences between repeats is gone with it
    _, repeatability = scatter_of_repeats(found.refits[trial.effects].fitted, found.baseline.train_plan)
    return ErrorReached(before, float(np.sqrt(trial.excess)), held, trial.held_out, repeatability)


def _history(found: SearchResult, decision: Decision) -> tuple[Step, ...]:
    steps = [Step((), float(np.sqrt(found.evidence.excess)), found.evidence.held_out)]
    if decision.trial is not None and decision.effects:
        for n in range(1, len(decision.effects) + 1):
            trial = found.evidence.trial_of(decision.trial.effects[:n])
            if trial is not None:
                steps.append(Step(trial.effects, float(np.sqrt(trial.excess)), trial.held_out))
    return tuple(steps)


def _confounding(found: SearchResult, criteria: Criteria) -> Confounding:
    names = tuple(s.effect.name for s in found.scored)
    groups: list[tuple[str, ...]] = [tuple(sorted((a, b))) for a, b, _ in found.evidence.alike]
    return Confounding(names, cosines(found.scored), criteria.cosine, tuple(dict.fromkeys(groups)))


def _words(found: SearchResult, candidates: Sequence[Candidate]) -> Wording:
    several = len(found.baseline.train_plan.repeats) > 1
    alone = "the noise of the runs" if found.baseline.plan.told_by_noise else "the scatter that is stated"
    scatter = "the scatter of the repeats" if several else alone
    return Wording({c.name: c.sentence for c in candidates}, scatter, unseen(found.baseline))
