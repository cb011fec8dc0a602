"""What a run says of a curve's stability: for summary.json, the table and the CSV."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability, State


def word(state: int) -> str:
    return State(int(state)).name.lower()


def stability_entry(curve: ResponseCurve, stability: BranchStability, point: str) -> dict[str, Any]:
    """points, share: by state; computed: at so many points themselves; unknown_because: reason -> points"""
    states = (State.STABLE, State.UNSTABLE, State.UNKNOWN)
    at_peak = int(np.abs(curve.receptance(point)).argmax()) if len(curve) else None
    return {
        "peak": word(stability.state[at_peak]) if at_peak is not None else None,
        "points": {word(state): int((stability.state == state).sum()) for state in states},
        "share": {word(state): round(stability.share(state), 4) for state in states},
        "unstable_Hz": stability.ranges(curve.frequency, State.UNSTABLE).tolist(),
        "unknown_Hz": stability.ranges(curve.frequency, State.UNKNOWN).tolist(),
        "unknown_because": {reason: int((stability.why == i).sum()) for i, reason in enumerate(stability.reasons)},
        "computed": int(stability.computed.sum()),
        "seconds": round(stability.seconds, 2),
    }


def doubtful_peaks(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on the curves' entries whose reported peak is unstable, or not known to be stable."""
    wording = {"unstable": "is unstable", "unknown": "is not known to be stable"}
    return [
        f"{entry['mode']} {entry['force_N']:g} N: the peak at {entry['peak_frequency_Hz']:.2f} Hz {wording[peak]}"
        for entry in entries
        if (peak := (entry.get("stability") or {}).get("peak")) in wording
    ]


def words(curve: ResponseCurve, stability: BranchStability | None) -> list[str]:
    """One a point; empty texts where it was not asked for"""
    return [""] * len(curve) if stability is None else [word(state) for state in stability.state]
