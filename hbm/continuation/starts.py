"""Starts of further segments between the open ends of what was traced: a little beyond an end, or at a fixed frequency
ahead of it.

What is grown from a start belongs to the curve where it meets the rest (hbm/continuation/pieces.py).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.curve_records import CurveRequest
from updamp.hbm.continuation.first_point import first_point
from updamp.hbm.continuation.recovery.jump import point_beyond_gap
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.newton import Solution, solve
from updamp.hbm.problem.system import NonlinearSystem


def starts(system: NonlinearSystem, request: CurveRequest, ends: Sequence[TracedBranch]) -> Iterator[BranchPoint]:
    """Solved points near the ends of the chains from both ends of the window, nearest first.

    ends: what was traced up to each end, at most two; the frequencies between them are looked at
    """
    options = request.options
    corrector = Corrector(system, request.excitation, options, options.scale_w(request.window))
    lengths = options.no_shorter(request.assembly.start_lengths)
    for newton in (options.newton, options.persistent):
        for traced in ends:
            point = point_beyond_gap(corrector, traced, lengths, newton)
            if point is not None:
                yield point
    for share in request.assembly.start_shares:
        for i, traced in enumerate(ends):
            other = ends[1 - i].last.w if len(ends) > 1 else np.inf * traced.last.tangent_w
            if (point := _at_frequency(system, request, traced.last, other, share)) is not None:
                yield point


def _at_frequency(
    system: NonlinearSystem, request: CurveRequest, last: BranchPoint, other: float, share: float
) -> BranchPoint | None:
    """At a fixed frequency, a share of the window from `last` towards the frequency `other` [rad/s], not beyond it."""
    low, high = (2 * np.pi * f for f in request.window)
    sign = float(np.sign(other - last.w)) or 1.0
    w = last.w + sign * share * (high - low)
    if sign * (w - other) >= 0 or not low < w < high:
        return None
    solution = _solved(system, request, last, w)
    if solution is None:
        return None
    return point_at(solution, request.excitation, last.metric.scale_w, (0 * solution.x, sign), last.distance(solution))


def _solved(system: NonlinearSystem, request: CurveRequest, last: BranchPoint, w: float) -> Solution | None:
    near = solve(system, request.excitation, last.x, w, request.options.persistent)
    if near.converged:
        return near
    try:
        return first_point(system, request.excitation, w, request.options.persistent)
    except BranchStoppedError:
        return None
