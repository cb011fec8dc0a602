"""What a run says where a curve's peak and the resonance followed in the force are not the same."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from updamp.hbm.continuation.completeness import half_width
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve

# Of a peak's height: within this the same curve comes out from its other end and with other round-off
# (tests/benchmarks/test_reproducibility.py).
REPRODUCED = 1e-3


def followed_entry(
    curve: ResponseCurve, followed: ResonanceCurve | None, point: str, error: Mapping[str, Any] | None
) -> dict[str, Any] | None:
    """Of the curve's force, where the resonance first passes it; None where it does not, or the curve has no point.

    error: what is stated of the curve's, None where it is not known
    `same_peak`: whether the height is the curve's within what is stated of it, at least `REPRODUCED`, and the frequency
    within the half-width of its peak
    """
    if followed is None or not len(curve) or not len(met := followed.passes(curve.force)):
        return None
    at, error = int(met[0]), error or {}
    frequency, height = float(followed.frequency[at]), float(abs(followed.receptance[at]))
    curves_frequency, curves_height = curve.peak(point)
    allowed = max(REPRODUCED, abs(error.get("peak_percent") or 0.0) / 100)
    width = max(half_width(curve.frequency, np.abs(curve.receptance(point))), abs(error.get("resonance_hertz") or 0.0))
    return {
        "frequency_Hz": frequency,
        "receptance_mm_per_N": 1e3 * height,
        "same_peak": bool(
            abs(height - curves_height) <= allowed * curves_height and abs(frequency - curves_frequency) <= width
        ),
    }


def different_peaks(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on the curves' entries whose peak is not that of the resonance followed in the force."""
    return [
        _sentence(entry, entry["followed"])
        for entry in entries
        if entry.get("followed") and not entry["followed"]["same_peak"]
    ]


def _sentence(entry: Mapping[str, Any], followed: Mapping[str, Any]) -> str:
    curves, other = entry["peak_receptance_mm_per_N"], followed["receptance_mm_per_N"]
    higher = "the curve's is the higher one" if curves >= other else "the one followed is higher"
    return (
        f"{entry['mode']} {entry['force_N']:g} N: the resonance followed in the force has {other:.5f} mm/N at "
        f"{followed['frequency_Hz']:.2f} Hz, the curve's peak {curves:.5f} mm/N at {entry['peak_frequency_Hz']:.2f} "
        f"Hz: not the same, {higher}"
    )
