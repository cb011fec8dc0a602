"""A response curve between its points: smooth lines where continuation took long steps."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from updamp.hbm.continuation.response_curve import ResponseCurve

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complex = NDArray[np.complex128]

BETWEEN = 12  # places drawn for each interval between two points


@dataclass(frozen=True, eq=False)
class SmoothBranch:
    """Places along a branch, in its order.

    frequency: (n,) [Hz]; receptance: (n,) complex [m/N]
    interval: (n,) number of the curve's interval that a place lies in: i from its point i to its point i + 1
    """

    frequency: Floats
    receptance: Complex
    interval: Integers

    def pieces(self) -> Iterator["SmoothBranch"]:
        """Parts without a gap between them."""
        for places in np.split(np.arange(len(self.interval)), 1 + np.flatnonzero(np.diff(self.interval) > 1)):
            if len(places):
                yield SmoothBranch(self.frequency[places], self.receptance[places], self.interval[places])


def smooth_branch(curve: ResponseCurve, point: str) -> SmoothBranch:
    """Frequency and the complex logarithm of the receptance, each interpolated over the length of the branch.

    Akima's method as modified in MATLAB (`makima`; H. Akima, J. ACM 17 (1970) 589): each interval depends on its two
    neighbours to both sides, so that a corner, where contacts begin to slip, sends no waves along the curve. The
    logarithm (amplitude and phase) is smooth over decades; how deep an antiresonance is between two points stays
    unknown. Lengths are those in the plane of the logarithm and of frequency over its range. It runs through all
    points, and not over gaps.
    """
    pieces = [_piece(curve, point, first, last) for first, last in followed(curve)]
    if not pieces:
        none = np.zeros(0)
        return SmoothBranch(none, none.astype(complex), none.astype(int))
    columns = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    return SmoothBranch(*columns)


def followed(curve: ResponseCurve) -> Iterator[tuple[int, int]]:
    """First and last point of each part that was followed without a gap; parts of a single point are left out."""
    ends = [0, *np.flatnonzero(curve.after_gap).tolist(), len(curve)]
    for first, after in pairwise(dict.fromkeys(ends)):
        if after - first > 1:
            yield first, after - 1


def _piece(curve: ResponseCurve, point: str, first: int, last: int) -> tuple[Floats, Complex, Integers]:
    frequency, receptance = curve.frequency[first : last + 1], curve.receptance(point)[first : last + 1]
    size = np.maximum(np.abs(receptance), np.finfo(float).tiny)
    values = np.column_stack([frequency, np.log(size), np.unwrap(np.angle(receptance))])
    length, count = _lengths(values), last - first
    at = np.append((np.arange(count)[:, None] + np.arange(BETWEEN) / BETWEEN).ravel(), count)
    if count > 1 and np.all(np.diff(length) > 0):
        place = np.interp(at, np.arange(count + 1), length)
        values = Akima1DInterpolator(length, values, method="makima")(place)
    else:  # a point met twice, or one interval alone
        values = np.column_stack([np.interp(at, np.arange(count + 1), column) for column in values.T])
    interval = first + np.minimum(at.astype(int), count - 1)
    return values[:, 0], np.exp(values[:, 1] + 1j * values[:, 2]), interval


def _lengths(values: Floats) -> Floats:
    """(n,) of the branch up to each of its points; values: (n, 3) frequency, logarithm of the size, phase"""
    steps = np.diff(values, axis=0) / [max(float(np.ptp(values[:, 0])), np.finfo(float).tiny), 1.0, 1.0]
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
