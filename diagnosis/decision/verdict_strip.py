"""How the verdict hangs on the repeatability that was stated."""

from dataclasses import replace

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.decision.probability import gain
from updamp.diagnosis.evidence import Evidence, Trial, gain_over_fewer
from updamp.diagnosis.verdict import StripEntry


def strip(evidence: Evidence, criteria: Criteria) -> tuple[StripEntry, ...]:
    """The verdict from each repeatability on where it changes; none where repeats tell how far a model may be off."""
    found: list[StripEntry] = []
    for i, of_null in enumerate(evidence.if_repeatable):
        decision = decide(_restated(evidence, i), criteria)
        entry = StripEntry(of_null.repeatability, decision.outcome, decision.outright + decision.group)
        if not found or (entry.verdict, entry.effects) != (found[-1].verdict, found[-1].effects):
            found.append(entry)
    return tuple(found)


def _restated(evidence: Evidence, i: int) -> Evidence:
    """As it would be with the i-th repeatability."""
    of_null = evidence.if_repeatable[i]

    def restated(t: Trial) -> Trial:
        if not t.if_repeatable:
            return t
        then = t.if_repeatable[i]
        drop = of_null.misfit - then.misfit
        t = replace(t, excess=then.excess, drop=drop, held_out=then.held_out, unseen=then.unseen)
        return replace(t, delta_bic=gain(t, evidence))

    trials = tuple(restated(t) for t in evidence.trials)
    combined = tuple(restated(t) for t in evidence.combined)
    gains = {frozenset(t.effects): t.delta_bic for t in (*trials, *combined)}
    return replace(
        evidence,
        excess=of_null.excess,
        held_out=of_null.held_out,
        unseen=of_null.unseen,
        trials=trials,
        combined=tuple(replace(t, delta_bic=gain_over_fewer(frozenset(t.effects), gains)) for t in combined),
    )
