"""From the evidence to the verdict."""

from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Evidence, Trial
from updamp.diagnosis.verdict import Outcome


@dataclass(frozen=True)
class Decision:
    """effects: those missing; group: effects of which one is, and the data do not tell which; trial: that rests on
    reason: why nothing is said though the misfit would allow it, "" otherwise"""

    outcome: Outcome
    effects: tuple[str, ...]
    group: tuple[str, ...]
    trial: Trial | None
    reason: str = ""


def decide(evidence: Evidence, criteria: Criteria) -> Decision:
    """A verdict that rests on a calibration, or on offsets of single runs, that nobody would believe is none."""
    decision = _by_misfit(evidence, criteria)
    rests_on = evidence if decision.trial is None else decision.trial
    off = far_off(rests_on, criteria)
    if decision.outcome == "unknown" or not off:
        return decision
    return Decision("undecidable", (), (), decision.trial, f"calibration first: {off}")


def far_off(fitted: Evidence | Trial, criteria: Criteria) -> str:
    """What a fit asks for that nobody would believe, "" if nothing."""
    if abs(fitted.deviations) < criteria.calibration:
        return ""
    return f"{fitted.farthest} {abs(fitted.deviations):.1f} deviations from what is stated"


def _by_misfit(evidence: Evidence, criteria: Criteria) -> Decision:
    accepted = [t for t in evidence.trials if not reason_against(t, evidence, criteria)]
    if not accepted:
        several = _best_combined(evidence, criteria, None)
        if several is not None:
            return Decision("identified", several.effects, (), several)
        return Decision(
            "unknown" if criteria.fails(evidence.excess, evidence.independent) else "adequate", (), (), None
        )
    best = min(accepted, key=lambda t: t.excess)
    several = _best_combined(evidence, criteria, best)
    if several is not None:
        return Decision("identified", several.effects, (), several)
    if still_fails(best, evidence, criteria):
        return Decision("unknown", (), (), best)
    equals = [t for t in accepted if t is not best and t.excess < (1 + criteria.as_good) * best.excess]
    if equals:
        group = (*best.effects, *(name for t in equals for name in t.effects))
        return Decision("inseparable", best.effects, group, best)
    return Decision("identified", best.effects, (), best)


def reason_against(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    """Why an effect is not accepted as the explanation, "" if it is."""
    if within_scatter(evidence):
        return "the model explains the data without it"
    for name in trial.effects:
        tested = evidence.test_of(name)
        if tested is not None and tested.visibility < criteria.visibility:
            return f"{name} is {not_identifiable(tested.visibility)}"
    if trial.delta_bic < criteria.delta_bic:
        return "the data do not ask for it"
    if not trial.full:
        return "others explain more"
    if trial.at_bound:
        return f"{trial.at_bound} would have to be beyond what is physical"
    if np.isfinite(trial.held_out) and trial.held_out > _allowed(evidence, criteria):
        return "runs that the fit never saw are not predicted better"
    return ""


def not_identifiable(visibility: float) -> str:
    """Why, in words. visibility: 0 where the effect has no signature"""
    why = "calibration can imitate it" if visibility > 0 else "it changes nothing in them"
    return f"not identifiable with these data: {why}"


def within_scatter(evidence: Evidence) -> bool:
    """Whether the model without effects is no further off than the scatter, on held-out runs too."""
    return evidence.excess <= 1 and not evidence.held_out > 1  # nan: nothing was held out


def _allowed(evidence: Evidence, criteria: Criteria) -> float:
    """Error on held-out runs: below that without the effect, or no larger where they were within the scatter before,
    since there is nothing to gain then (what shows at the highest level alone need not show below it)."""
    badly = criteria.is_doubtful(evidence.unseen, evidence.unseen_independent)
    return (1 - criteria.gain) * evidence.held_out if badly else evidence.held_out


def _best_combined(evidence: Evidence, criteria: Criteria, single: Trial | None) -> Trial | None:
    """Two effects and more where one is not enough: all needed, and no two that look alike."""
    good = [
        p
        for p in evidence.combined
        if not reason_against(p, evidence, criteria)
        and not _alike(evidence, p.effects, criteria)
        and not still_fails(p, evidence, criteria)
    ]
    if single is not None:
        # a second effect has to make up for a misfit that stands out, not for the last tenths of it
        enough = not criteria.is_doubtful(single.excess, evidence.independent)
        good = [] if enough else [p for p in good if (1 + criteria.as_good) * p.excess < single.excess]
    return min(good, key=lambda p: p.excess, default=None)


def still_fails(trial: Trial, evidence: Evidence, criteria: Criteria) -> bool:
    """Whether it leaves more than chance can, on held-out runs too."""
    unseen = criteria.fails(trial.unseen, evidence.unseen_independent)
    return criteria.fails(trial.excess, evidence.independent) or unseen


def _alike(evidence: Evidence, effects: tuple[str, ...], criteria: Criteria) -> bool:
    return any({a, b} <= set(effects) and cosine > criteria.cosine for a, b, cosine in evidence.alike)
