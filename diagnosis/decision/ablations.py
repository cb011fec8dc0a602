"""The verdict without a part of the method: to see what each part is worth."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.evidence import EffectScore, Evidence
from updamp.parallel.whole_file import write_whole

VerdictSummary = tuple[str, tuple[str, ...], tuple[str, ...]]
# Score above which a test alone would call an effect found.
_FOUND = 6.0


def ablations(evidence: Evidence, criteria: Criteria) -> dict[str, VerdictSummary]:
    """Name -> verdict, effects and group: by the residual's likeness to the signature alone, by the score test alone
    with and without scatter, by BIC alone, and without held-out runs."""
    doubtful = criteria.is_doubtful(evidence.excess, evidence.freedom)
    return {
        "no orthogonalisation": _by(evidence, lambda t: t.alone, doubtful),
        "no scatter": _by(evidence, lambda t: t.without_scatter, True, _FOUND),
        "score only": _by(evidence, lambda t: t.score, True, _FOUND),
        "BIC only": _by_bic(evidence, criteria),
        "no held-out runs": _without_held_out(evidence, criteria),
    }


def _by(evidence: Evidence, value: Callable[[EffectScore], float], found: bool, limit: float = 0.0) -> VerdictSummary:
    best = max(evidence.tested, key=value, default=None)
    if best is None or not found or value(best) < limit:
        return "adequate", (), ()
    return "identified", (best.effect,), ()


def _by_bic(evidence: Evidence, criteria: Criteria) -> VerdictSummary:
    best = max(evidence.trials, key=lambda t: t.delta_bic, default=None)
    if best is None or best.delta_bic < criteria.delta_bic:
        return "adequate", (), ()
    return "identified", best.effects, ()


def _without_held_out(evidence: Evidence, criteria: Criteria) -> VerdictSummary:
    nan = float("nan")
    blind = replace(
        evidence,
        trials=tuple(replace(t, held_out=nan, unseen=nan) for t in evidence.trials),
        combined=tuple(replace(t, held_out=nan, unseen=nan) for t in evidence.combined),
    )
    decision = decide(blind, criteria)
    return decision.outcome, decision.effects, decision.group


def write_ablations(path: Path, evidence: Evidence, criteria: Criteria) -> None:
    summaries: Mapping[str, VerdictSummary] = ablations(evidence, criteria)
    document = {name: {"verdict": v, "effects": list(e), "group": list(g)} for name, (v, e, g) in summaries.items()}
    write_whole(path, (json.dumps(document, indent=1) + "\n").encode())
