"""How far a curve is from the same one with more harmonics: both traced, and compared where a reader looks.

Points solved again near the first ones (hbm/analysis/accuracy.py) cost less and tell as much where the branch hardly
moves. Where contacts open and little holds the mean position it moves by many half-widths, and only another trace
tells.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.completeness import half_width
from updamp.hbm.continuation.response_curve import ResponseCurve

Floats = NDArray[np.float64]

# Flanks reach from the half-width to where the response has fallen to this share of the peak.
FLANK_DOWN_TO = 0.1


@dataclass(frozen=True)
class CurveError:
    """The finer curve less the first one; not a number where one of them has no such value.

    orders: harmonics of the finer curve; peak_percent, half_width_percent: in percent of the first one's
    resonance_hertz: shift of the peak's frequency
    flank_percent: largest change of the amplitude at the same frequency beyond the half-width, down to a tenth of the
        peak, in percent of it
    complete: whether the finer curve is; if not, its peak may be another one
    """

    orders: tuple[int, ...]
    peak_percent: float
    resonance_hertz: float
    half_width_percent: float
    flank_percent: float
    complete: bool


def curve_error(curve: ResponseCurve, finer: ResponseCurve, point: str) -> CurveError:
    """raises: ValueError for a curve without points, or naming the points there are"""
    if not len(curve) or not len(finer):
        raise ValueError("a curve without points has no error: trace it first")
    (at, peak), (finer_at, finer_peak) = curve.peak(point), finer.peak(point)
    sizes = [np.abs(one.receptance(point)) for one in (curve, finer)]
    widths = [half_width(one.frequency, size) for one, size in zip((curve, finer), sizes, strict=True)]
    flank = (np.abs(curve.frequency - at) > widths[0]) & (sizes[0] > FLANK_DOWN_TO * peak)
    changes = _changes(curve.frequency[flank], sizes[0][flank], finer.frequency, sizes[1])
    return CurveError(
        orders=finer.orders,
        peak_percent=100 * (finer_peak / peak - 1),
        resonance_hertz=finer_at - at,
        half_width_percent=100 * (widths[1] / widths[0] - 1) if np.isfinite(widths).all() else np.nan,
        flank_percent=100 * float(np.nanmax(np.abs(changes), initial=0.0)) if len(changes) else np.nan,
        complete=finer.complete,
    )


def _changes(frequency: Floats, size: Floats, finer_frequency: Floats, finer_size: Floats) -> Floats:
    """(n,) relative change to the finer branch's nearest sheet at each frequency; not a number where there is none."""
    changes = np.full(len(frequency), np.nan)
    start, end = finer_frequency[:-1], finer_frequency[1:]
    for i, at in enumerate(frequency):
        across = np.flatnonzero((np.minimum(start, end) <= at) & (at <= np.maximum(start, end)) & (start != end))
        if len(across):
            share = (at - start[across]) / (end - start)[across]
            there = finer_size[across] + share * (finer_size[across + 1] - finer_size[across])
            change = there / size[i] - 1
            changes[i] = change[np.argmin(np.abs(change))]
    return changes
