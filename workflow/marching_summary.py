"""What a run says of peaks marched in time: for summary.json and the table."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from updamp.hbm.time_marching.marched_peak import MarchedPeak, Verdict


def marching_entry(found: MarchedPeak) -> dict[str, Any]:
    """None where there is no number"""
    return {
        "verdict": Verdict(found.verdict).name.lower().replace("_", " "),
        "sentence": found.sentence,
        "periods": found.periods,
        "moved_percent": _percent(found.moved),
        "reach_percent": _percent(found.reach),
        "growth_per_s": float(found.growth) if np.isfinite(found.growth) else None,
        "growth_error": float(found.growth_error),
        "not_marched_further": found.reason,
        "seconds": round(found.seconds, 2),
    }


def _percent(share: float) -> float | None:
    return float(100 * share) if np.isfinite(share) else None


def moving_peaks(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on the curves' entries whose reported peak does not stay, or was not checked."""
    return [
        f"{entry['mode']} {entry['force_N']:g} N: the peak at {entry['peak_frequency_Hz']:.2f} Hz {marched['sentence']}"
        f"{_without_mean(entry, marched['verdict'])}"
        for entry in entries
        if (marched := entry.get("marching")) and marched["verdict"] != "stays" and entry["points"]
    ]


def _without_mean(entry: Mapping[str, Any], verdict: str) -> str:
    held = verdict == "moves" and 0 not in entry["harmonics"]
    return "; harmonic 0, the mean position, is not among those it keeps" if held else ""


def marching_remark(entry: Mapping[str, Any]) -> list[str]:
    """For the table's last column"""
    verdict = (entry.get("marching") or {}).get("verdict")
    return [f"[red]{verdict}[/]"] if verdict in ("moves", "leaves") else []
