"""What a run says of branches beside a curve: for summary.json, and in sentences."""

from collections.abc import Mapping, Sequence
from typing import Any

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.quadrature import quadrature_resonances
from updamp.hbm.stability.detached_branches import DetachedBranches
from updamp.workflow.stability_summary import word


def detached_entries(found: DetachedBranches | None, point: str) -> list[dict[str, Any]]:
    """One a branch, the highest first; peak and its stability, and all passes of phase quadrature"""
    if found is None:
        return []
    entries = [_entry(*one, point) for one in zip(found.branches, found.state.tolist(), found.reasons, strict=True)]
    return sorted(entries, key=lambda entry: -float(entry["peak_receptance_mm_per_N"]))


def _entry(branch: ResponseCurve, state: int, reason: str, point: str) -> dict[str, Any]:
    at, peak = branch.peak(point)
    return {
        "from_Hz": float(branch.frequency.min()),
        "to_Hz": float(branch.frequency.max()),
        "closed": branch.complete,
        "problem": branch.stopped,
        "points": len(branch),
        "peak_receptance_mm_per_N": 1e3 * peak,
        "peak_frequency_Hz": at,
        "peak_stability": word(state),
        "peak_stability_unknown_because": reason,
        "resonances": [
            {"frequency_Hz": r.frequency, "receptance_mm_per_N": 1e3 * r.receptance}
            for r in quadrature_resonances(branch, point)
        ],
    }


def coexisting(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on the curves' entries that have branches beside them."""
    return [
        f"{entry['mode']} {entry['force_N']:g} N: {_sentence(one)}{_against(one, entry)}"
        for entry in entries
        for one in entry.get("detached", ())
    ]


STABILITY = {"stable": "stable", "unstable": "unstable", "unknown": "not known to be stable"}


def _sentence(one: Mapping[str, Any]) -> str:
    stable = STABILITY[one["peak_stability"]]
    what = "a closed loop" if one["closed"] else "a branch, followed in part,"
    return (
        f"{what} from {one['from_Hz']:.2f} to {one['to_Hz']:.2f} Hz is no part of the curve; its largest response is "
        f"{one['peak_receptance_mm_per_N']:.5f} mm/N at {one['peak_frequency_Hz']:.2f} Hz, {stable}"
    )


def _against(one: Mapping[str, Any], entry: Mapping[str, Any]) -> str:
    peak = entry["peak_receptance_mm_per_N"]
    if peak is None or one["peak_receptance_mm_per_N"] <= peak:
        return ""
    return f", higher than the curve's peak of {peak:.5f} mm/N"
