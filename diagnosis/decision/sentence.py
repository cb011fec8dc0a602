"""The verdict in a sentence that says no more than the evidence does."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import Decision, far_off, reason_against, still_fails
from updamp.diagnosis.evidence import Evidence, Trial

# Explanations that are told where none is good enough.
_CLOSEST = 3
_NOTHING_HELD_OUT = "; no run was held out"


@dataclass(frozen=True)
class Wording:
    """effects: what each says, by name; scatter: what errors are told in; unseen: what the held-out error is of"""

    effects: Mapping[str, str]
    scatter: str
    unseen: str


def sentence(decision: Decision, evidence: Evidence, criteria: Criteria, words: Wording) -> str:
    """The verdict in plain words."""
    before, trial = float(np.sqrt(evidence.excess)), decision.trial
    if decision.outcome == "adequate":
        return (
            f"nothing is missing that these data show: the calibrated model is off by {before:.2f} times "
            f"{words.scatter}{_held_out(evidence, words)}{_alone_off(evidence, criteria)}"
            f"{_asked_for(evidence, criteria)}"
        )
    if decision.outcome == "unknown":
        return _of_unknown(evidence, criteria, words)
    if decision.outcome == "undecidable":
        return _of_undecidable(decision, evidence, criteria, words)
    assert trial is not None, "an effect has been chosen by its fit"
    fall = f"the error falls from {before:.1f} to {trial.excess**0.5:.2f} times {words.scatter}"
    if np.isfinite(trial.held_out):
        fall += f", on {words.unseen} from {evidence.held_out:.1f} to {trial.held_out:.2f}"
    else:
        fall += _NOTHING_HELD_OUT
    if criteria.is_doubtful(trial.excess, evidence.freedom):
        rarely = f"chance leaves as much in one test of {1 / criteria.doubtful:.0f} at most"
        fall += f"; {rarely}: it may not be all, or a like law"
    if decision.outcome == "inseparable":
        return f"{_apart(decision, words)}, and these data do not tell which: {fall}"
    return f"{_told(decision.effects, words)}: {fall}"


def _of_undecidable(decision: Decision, evidence: Evidence, criteria: Criteria, words: Wording) -> str:
    found_so = ""
    if decision.trial is None and criteria.fails(evidence.unseen, evidence.unseen_freedom):
        found_so = f"; it is off by {evidence.excess**0.5:.2f} times {words.scatter}{_held_out(evidence, words)}"
    return f"{decision.reason}{found_so}. {decision.advice}"


def _told(effects: Sequence[str], words: Wording) -> str:
    return f"{' and '.join(words.effects[e] for e in effects)} ({', '.join(effects)})"


def _apart(decision: Decision, words: Wording) -> str:
    """What is missing whichever it is, and of how many it is not told which they are."""
    left = len(decision.effects) - len(decision.outright)
    some = f"{'one' if left == 1 else left} of {', '.join(decision.group)} {'is' if left == 1 else 'are'} missing"
    return f"{_told(decision.outright, words)}, and {some} beside" if decision.outright else some


def _held_out(evidence: Evidence, words: Wording) -> str:
    if not np.isfinite(evidence.held_out):
        return _NOTHING_HELD_OUT
    return f", on {words.unseen} by {evidence.held_out:.2f}"


def _alone_off(evidence: Evidence, criteria: Criteria) -> str:
    """What one thing that is off in the held-out runs alone would make of them, where they are further off."""
    doubtful = criteria.is_doubtful(evidence.unseen, evidence.unseen_freedom)
    if not (doubtful and criteria.is_far_off(evidence.unseen_deviations, evidence.stated)):
        return ""
    off = f"{evidence.unseen_farthest} {abs(evidence.unseen_deviations):.0f} deviations off"
    return f", as with {off}: look at these runs first"


def _asked_for(evidence: Evidence, criteria: Criteria) -> str:
    """What the data of the fit ask for and is not accepted all the same, with the reason."""
    asked = next((t for t in _settled(evidence) if t.delta_bic >= criteria.delta_bic), None)
    return "" if asked is None else f"; {_leaves(asked)}, but {_why(asked, evidence, criteria)}"


def _of_unknown(evidence: Evidence, criteria: Criteria, words: Wording) -> str:
    """What was tried and left least, with what it predicted of held-out runs, and what speaks against it."""
    best, before = _settled(evidence)[:_CLOSEST], float(np.sqrt(evidence.excess))
    off = f"the model is off by {before:.1f} times {words.scatter}"
    if all(still_fails(t, evidence, criteria) for t in best):
        said = f"something is missing that the catalogue does not have: {off}, and no effect explains it"
    else:
        said = f"something is missing that cannot be named: {off}, and nothing that explains it is accepted"
    left = [_in_the_way(t, evidence, criteria) for t in best]
    closest = f". Closest: {'; '.join(left)}" if left else ""
    return said + _if_runs_drift(evidence, words) + closest


def _if_runs_drift(evidence: Evidence, words: Wording) -> str:
    """That it is the runs which differ, where that describes all of them."""
    free = evidence.if_runs_drift
    if free is None:
        return ""
    return (
        f". With a resonance of its own for every run the model is off by {free.excess**0.5:.2f} times {words.scatter}:"
        f" the runs lie {100 * free.drift:.2g} % apart (standard deviation), whatever the level, as where a structure "
        f"warms up or a clamp settles. If it is that, state frequency_drift = {free.drift:.1g} in the measurement file"
    )


def _in_the_way(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    off = far_off(trial, evidence, criteria)
    told = _leaves(trial) + (f" with {off}" if off else "")
    return told if still_fails(trial, evidence, criteria) else f"{told}, but {_why(trial, evidence, criteria)}"


def _why(trial: Trial, evidence: Evidence, criteria: Criteria) -> str:
    """Of what explains the data and is not named; several that nothing else speaks against are one too many."""
    return reason_against(trial, evidence, criteria) or "one of them alone leaves hardly more"


def _settled(evidence: Evidence) -> list[Trial]:
    """Fits that were left to settle, what leaves least first."""
    return sorted((t for t in (*evidence.trials, *evidence.combined) if t.full), key=lambda t: t.excess)


def _leaves(trial: Trial) -> str:
    held_out = f" ({trial.held_out:.1f} on held-out runs)" if np.isfinite(trial.held_out) else ""
    leave = "leaves" if len(trial.effects) == 1 else "leave"
    return f"{' and '.join(trial.effects)} {leave} {trial.excess**0.5:.1f} times{held_out}"
