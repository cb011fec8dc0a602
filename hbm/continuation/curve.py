"""Trace a response curve: continuation, with what is to be kept of every point."""

import time
from collections.abc import Iterator, Sequence

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, branch_point
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.continuation.curve_records import CurveRequest, Records
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.segment import BranchSegment
from updamp.hbm.continuation.two_ends import from_both_ends
from updamp.hbm.problem.system import NonlinearSystem

__all__ = ["CurveRequest", "trace"]


# So many points are traced from one end alone, as many as most curves have; then from both in turn. A branch that goes
# on as it should costs no more that way; one that was lost at a kink is met from the other end.
_FROM_ONE_END = 200


def trace(
    system: NonlinearSystem, request: CurveRequest, resume_from: ResponseCurve | None = None
) -> Iterator[ResponseCurve]:
    """The curve so far, after every point; the last one handed out is `complete` or says why it `stopped`.

    resume_from: an interrupted curve of the same system and request; only what follows it is solved
    raises: nothing; a branch that cannot go on ends the curve with its sentence in `stopped`
    """
    started = time.perf_counter()
    if resume_from is not None and (resume_from.complete or resume_from.stopped):
        yield resume_from
        return
    earlier = resume_from if resume_from is not None and len(resume_from) >= 2 else None
    first = _segment(system, request, request.upwards, started, earlier)
    while first.active and len(first.records) < _FROM_ONE_END:
        if first.next_point() is not None:
            yield first.curve()
    if first.crossed_window:
        yield first.curve()
        return
    yield from from_both_ends(system, request, first, _segment(system, request, not request.upwards, started))


def _segment(
    system: NonlinearSystem, request: CurveRequest, upwards: bool, started: float, earlier: ResponseCurve | None = None
) -> BranchSegment:
    """From the lower end of the window (upwards) or the upper one; earlier: what there is of it"""
    resumed = _last_points(system, request, earlier) if earlier is not None else ()
    points = continue_branch(system, request.excitation, request.window, request.options, upwards, resumed)
    return BranchSegment(Records(system, request, started, earlier), 1.0 if upwards else -1.0, points, resumed)


def _last_points(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> Sequence[BranchPoint]:
    """The last two points of a stored curve as points of a branch, tangents computed anew."""
    scale_w = request.options.scale_w(request.window)
    places = [(curve.displacement[i], 2 * np.pi * curve.frequency[i]) for i in (-2, -1)]
    direction = (places[1][0] - places[0][0], places[1][1] - places[0][1])
    return [branch_point(system, request.excitation, x, w, scale_w, direction) for x, w in places]
