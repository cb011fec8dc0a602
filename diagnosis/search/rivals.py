"""Explanations that the data so far leave side by side, for a next measurement to tell apart."""

from updamp.diagnosis.residual.fit import Fit
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.decide import Decision
from updamp.diagnosis.search.evidence import Trial
from updamp.diagnosis.search.search import Found

NOTHING = "nothing missing"
# Each is predicted with every run.
_MOST = 3


def rivals(found: Found, decision: Decision, criteria: Criteria) -> dict[str, Fit]:
    """Name of the explanation -> its fit, the best first; at least two, or none where nothing is to be told apart.

    inseparable: the group; unknown: the best effects, as far as they explain nearly as much; adequate: that nothing is
    missing and the best effect that the data of the fit alone would ask for
    """
    evidence = found.evidence
    settled = sorted((t for t in (*evidence.trials, *evidence.pairs) if t.full), key=lambda t: t.excess)
    if decision.outcome == "inseparable":
        chosen = [t for t in settled if len(t.effects) == 1 and t.effects[0] in decision.group]
    elif decision.outcome == "unknown":
        chosen = [t for t in settled if t.drop > 0 and t.excess < criteria.close * settled[0].excess]
    elif decision.outcome == "adequate":
        near = [t for t in settled if t.delta_bic >= criteria.delta_bic][:1]
        return {NOTHING: found.baseline.fitted, **_fits(found, near)} if near else {}
    else:
        chosen = []
    return _fits(found, chosen[:_MOST]) if len(chosen) > 1 else {}


def _fits(found: Found, trials: list[Trial]) -> dict[str, Fit]:
    return {" and ".join(t.effects): found.refits[t.effects].fitted for t in trials}
