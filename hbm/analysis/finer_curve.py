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
from updamp.hbm.continuation.smooth_branch import smooth_branch
from updamp.hbm.newton.metric import to_lines

Floats = NDArray[np.float64]

# Flanks reach from the half-width to where the response has fallen to this share of the peak.
FLANK_DOWN_TO = 0.1


@dataclass(frozen=True)
class CurveError:
    """The finer curve less the first one; not a number where one of them has no such value.

    orders: harmonics of the finer curve; peak_percent, half_width_percent: in percent of the first one's
    resonance_hertz: shift of the peak's frequency
    flank_percent: largest distance to the finer curve (`distances`) beyond the half-width, down to a tenth of the peak
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
    size = np.abs(curve.receptance(point))
    widths = [_half_width(one, point) for one in (curve, finer)]
    flank = np.flatnonzero((np.abs(curve.frequency - at) > widths[0]) & (size > FLANK_DOWN_TO * peak))
    apart = distances(curve, finer, point, widths[0], flank)
    return CurveError(
        orders=finer.orders,
        peak_percent=100 * (finer_peak / peak - 1),
        resonance_hertz=finer_at - at,
        half_width_percent=100 * (widths[1] / widths[0] - 1) if np.isfinite(widths).all() else np.nan,
        flank_percent=100 * float(apart.max()) if len(apart) else np.nan,
        complete=finer.complete,
    )


def _half_width(curve: ResponseCurve, point: str) -> float:
    """[Hz], between the points on smooth lines: straight ones make as much of a change of the points as of the finer
    model's."""
    near = smooth_branch(curve, point)
    return half_width(near.frequency, np.abs(near.receptance), curve.peak(point)) if len(near.frequency) else np.nan


def distances(
    curve: ResponseCurve, finer: ResponseCurve, point: str, width: float, places: NDArray[np.int64]
) -> Floats:
    """(n,) from the n points of a curve at these places to the nearest one of the finer branch: across the branch,
    where the change at fixed frequency grows without bound as a flank becomes vertical.

    d^2 = |h' / h - 1|^2 + ((f' - f) / width)^2, least over the points (f', h') of the finer branch, h the receptance at
    `point`, width the half-width [Hz]. Both parts weigh the same: a linear resonance is h = 1 / (1 + i s), s the
    frequency in half-widths off resonance, |d ln h / ds| = 1 / sqrt(1 + s^2) <= 1, so that a shift counts for no more
    than the change that it makes on such a resonance where that is largest. Where a branch runs at a slope g =
    |d ln h / ds| and the finer one beside it differs by e at fixed frequency, d = e / sqrt(1 + g^2): the change of the
    response on a shallow flank, the shift e / g in half-widths on a steep one. It is the metric of continuation
    (hbm/newton/metric.py) at one point.

    returns: not a number where the finer curve has no branch, or the width is not finite
    """
    near = smooth_branch(finer, point)
    if not len(near.frequency) or not np.isfinite(width):
        return np.full(len(places), np.nan)
    followed = np.diff(near.interval) <= 1
    apart = np.empty(len(places))
    receptance = curve.receptance(point)
    for i, (at, h) in enumerate(zip(curve.frequency[places], receptance[places], strict=True)):
        change, shift = (near.receptance / h - 1)[:, None].view(float), (near.frequency - at) / width
        apart[i] = to_lines(np.column_stack([change, shift]))[0][followed].min()
    return apart
