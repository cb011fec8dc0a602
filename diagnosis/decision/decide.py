"""From the evidence to the verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.probability import gain, weights
from updamp.diagnosis.evidence import Evidence, Trial
from updamp.diagnosis.verdict import Outcome

_CHECK = "Check it, and what the files state of it, before anything is named"
_OTHER_RUNS = "None of these is named: measure what tells them apart, or let the fit see other runs (--hold-out)"
_FIT_ALL = "What is missing shows in these: hold out other runs (--hold-out), so that the fit sees it"


@dataclass(frozen=True)
class Decision:
    """effects: those missing; group: effects of which one is, and the data do not tell which; trial: that rests on
    reason: why nothing is said though the misfit would allow it, "" otherwise; advice: what to do about it
    alternatives: fits that explain the data as well, that one first; none where it is the only one. Of "undecidable"
        those that are beside each other, the likeliest first"""

    outcome: Outcome
    effects: tuple[str, ...]
    group: tuple[str, ...]
    trial: Trial | None
    reason: str = ""
    advice: str = ""
    alternatives: tuple[Trial, ...] = ()

    @property
    def outright(self) -> tuple[str, ...]:
        """Those missing whichever of the group is."""
        return tuple(e for e in self.effects if e not in self.group)


def decide(evidence: Evidence, criteria: Criteria) -> Decision:
    """A verdict that rests on a calibration, or on offsets of single runs, that nobody would believe is none."""
    decision = _by_misfit(evidence, criteria)
    rests_on = evidence if decision.trial is None else decision.trial
    off = far_off(rests_on, evidence, criteria)
    if decision.outcome == "unknown" or not off:
        return decision
    with_it = f"; {_these([decision.trial])} would explain the data with it" if decision.trial else ""
    return Decision("undecidable", (), (), decision.trial, f"calibration first: {off}{with_it}", _CHECK)


def far_off(fitted: Evidence | Trial, evidence: Evidence, criteria: Criteria) -> str:
    """What a fit asks for that nobody would believe, "" if nothing."""
    if not criteria.is_far_off(fitted.deviations, evidence.stated):
        return ""
    return f"{fitted.farthest} {abs(fitted.deviations):.1f} deviations from what is stated"


def _by_misfit(evidence: Evidence, criteria: Criteria) -> Decision:
    accepted = [t for t in evidence.trials if not reason_against(t, evidence, criteria)]
    single = min(accepted, key=lambda t: t.excess, default=None)
    several = _combined(evidence, criteria, single)
    if several:
        return _named(max(several, key=lambda t: gain(t, evidence)), several, evidence, criteria)
    if single is None:
        return _without_effects(evidence, criteria)
    if still_fails(single, evidence, criteria):
        return Decision("unknown", (), (), single)
    return _named(single, accepted, evidence, criteria)


def _without_effects(evidence: Evidence, criteria: Criteria) -> Decision:
    """None is accepted. What a calibration makes up for in the runs of the fit shows in the others, where it does not
    hold, and no effect was looked for there."""
    if criteria.fails(evidence.excess, evidence.freedom):
        return Decision("unknown", (), (), None)
    if criteria.fails(evidence.unseen, evidence.unseen_freedom):
        return Decision(
            "undecidable", (), (), None, "the calibrated model explains the runs of the fit alone", _FIT_ALL
        )
    return Decision("adequate", (), (), None)


def _named(best: Trial, accepted: Sequence[Trial], evidence: Evidence, criteria: Criteria) -> Decision:
    """The best, or that the data do not tell it from others of as many effects by a calibration that can be believed;
    what all of these have is missing whichever it is.

    Neither what they leave tells them apart, nor the information criterion, of those that explain the data. Whether it
    asks for all of a rival's effects does not matter there: one of them may do most of it, and still not suffice.
    What is less likely than others that something speaks against is not named either.
    """
    as_many = [
        t for t in (*evidence.trials, *evidence.combined) if len(t.effects) == len(best.effects) and t is not best
    ]
    as_good = [
        t
        for t in as_many
        if (t in accepted and t.excess < (1 + criteria.as_good) * best.excess)
        or (_explains(t, evidence, criteria) and gain(best, evidence) - gain(t, evidence) < criteria.delta_bic)
    ]
    equals = [t for t in as_good if not far_off(t, evidence, criteria)]
    alternatives = (best, *equals)
    if likelier := _likelier(alternatives, as_many, evidence, criteria):
        return _between(likelier, alternatives, evidence, criteria)
    if not equals:
        return Decision("identified", best.effects, (), best)
    named = dict.fromkeys(name for t in alternatives for name in t.effects)
    group = tuple(name for name in named if not all(name in t.effects for t in alternatives))
    return Decision("inseparable", best.effects, group, best, alternatives=alternatives)


def _likelier(
    alternatives: Sequence[Trial], as_many: Sequence[Trial], evidence: Evidence, criteria: Criteria
) -> Trial | None:
    """Of what is not accepted the likeliest, where all of that is likelier than these; None where these are.

    Only what could be the truth counts: with a calibration that can be believed, sizes that are physical, and effects
    that the data can show.
    """
    others = [
        t
        for t in as_many
        if t not in alternatives
        and t.full
        and not (t.at_bound or far_off(t, evidence, criteria) or _not_seen(t, evidence, criteria))
    ]
    likely = weights([*alternatives, *others], evidence)[1:]
    for_these, against = likely[: len(alternatives)], likely[len(alternatives) :]
    return others[int(np.argmax(against))] if against.sum() > for_these.sum() else None


def _between(likelier: Trial, alternatives: tuple[Trial, ...], evidence: Evidence, criteria: Criteria) -> Decision:
    """Nothing is named where the likelier is not accepted and the accepted is not likely."""
    why = _against_the_fit(likelier, evidence, criteria) or "it leaves more than chance can"
    reason = f"{_these([likelier])} would be likelier than {_these(alternatives)}, but {why}"
    return Decision("undecidable", (), (), alternatives[0], reason, _OTHER_RUNS, (likelier, *alternatives))


def _these(trials: Sequence[Trial]) -> str:
    return " or ".join(" and ".join(t.effects) for t in trials)


def reason_against(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    """Why an effect is not accepted as the explanation, "" if it is."""
    if within_scatter(evidence):
        return "the model explains the data without it"
    if hidden := _not_seen(trial, evidence, criteria):
        return hidden
    if trial.delta_bic < criteria.delta_bic:
        return "the data do not ask for it"
    return _against_the_fit(trial, evidence, criteria)


def _explains(trial: Trial, evidence: Evidence, criteria: Criteria) -> bool:
    """Whether a fit explains the data, on held-out runs too, by effects that can be seen."""
    against = _not_seen(trial, evidence, criteria) or _against_the_fit(trial, evidence, criteria)
    return not against and not still_fails(trial, evidence, criteria)


def _not_seen(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    """Which of a fit's effects these data cannot show, "" if none: one that calibration imitates for the most part, of
    whose rest the data have nothing. A stiffer wire shifts all resonances, and the little that it does besides may
    still stand out of the noise."""
    for name in trial.effects:
        tested = evidence.test_of(name)
        if tested is None or tested.visibility >= criteria.visibility:
            continue
        if tested.score < criteria.search.score:
            return f"{name} is {not_identifiable(tested.visibility)}"
    return ""


def _against_the_fit(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    """Why a fit is no explanation, "" if it may be one."""
    if not trial.full:
        return "others explain more"
    if trial.at_bound:
        return f"{trial.at_bound} would have to be beyond what is physical"
    if trial.may_be_absent:
        return f"the interval of {trial.may_be_absent} holds none of it"
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
    badly = criteria.is_doubtful(evidence.unseen, evidence.unseen_freedom)
    return (1 - criteria.gain) * evidence.held_out if badly else evidence.held_out


def _combined(evidence: Evidence, criteria: Criteria, single: Trial | None) -> list[Trial]:
    """Two effects and more where one is not enough, or by a calibration alone that nobody would believe: all needed, as
    the criterion asks for each over the best set without it. Those whose calibration can be believed go first."""
    good = [
        p
        for p in evidence.combined
        if not reason_against(p, evidence, criteria) and not still_fails(p, evidence, criteria)
    ]
    believable = [p for p in good if not far_off(p, evidence, criteria)]
    if single is None:
        return believable or good
    if far_off(single, evidence, criteria) and believable:
        return believable
    if not criteria.is_doubtful(single.excess, evidence.freedom):
        return []  # a second effect has to make up for a misfit that stands out, not for the last tenths of it
    return [p for p in good if (1 + criteria.as_good) * p.excess < single.excess]


def still_fails(trial: Trial, evidence: Evidence, criteria: Criteria) -> bool:
    """Whether it leaves more than chance can, on held-out runs too."""
    unseen = criteria.fails(trial.unseen, evidence.unseen_freedom)
    return criteria.fails(trial.excess, evidence.freedom) or unseen
