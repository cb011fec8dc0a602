"""Trace a response curve: continuation, with what is to be kept of every point.

Most curves are one segment, from one end of the window to the other. Where that one stops, or winds for long, or where
another solution is at the other end, the curve is traced from there too, until the two meet; where they do not, from
further starts between their ends, in both directions (hbm/continuation/pieces.py). What is found on the way and is no
part of the branch is kept beside it (hbm/continuation/detached.py).
"""

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from updamp.hbm.continuation.branch import point_at
from updamp.hbm.continuation.completeness import shortcoming
from updamp.hbm.continuation.curve_records import CurveRequest, put_together
from updamp.hbm.continuation.detached import apart, middle, missing, within
from updamp.hbm.continuation.extremes import with_extremes_solved
from updamp.hbm.continuation.half_problem import HalfProblem
from updamp.hbm.continuation.hardly_felt import with_hardly_felt_resonances
from updamp.hbm.continuation.pieces import BranchSegment, Pieces
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.segments import from_end, segment_from
from updamp.hbm.continuation.settled_laws import unsettled
from updamp.hbm.continuation.starts import starts
from updamp.hbm.continuation.window_ends import cut_at_window
from updamp.hbm.newton.equation import linear_solution
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.system import NonlinearSystem

__all__ = ["CurveRequest", "trace", "whole_curve"]

# Growth after which a curve that is being traced is copied again, as a share of its points: n points one by one would
# be n^2 / 2 of them.
_COPIED = 0.01


def trace(system: NonlinearSystem, request: CurveRequest) -> Iterator[ResponseCurve]:
    """The curve so far, after every point; the last one handed out is `complete` or says why it `stopped`.

    Of a problem that is its own mirror image half is solved (hbm/problem/mirror.py), and `active` counts its rows.
    Beyond a hundred points a curve is handed out again until it has grown by a hundredth: it is copied as a whole.

    raises: nothing; a branch that cannot go on ends the curve with its sentence in `stopped`
    """
    if (half := HalfProblem.of(system, request)) is None:
        yield from _traced(system, request)
        return
    shown = whole = None
    for curve in _traced(half.system, half.request):
        if whole is None or curve is not shown:
            shown, whole = curve, half.whole(curve)
        yield whole


def whole_curve(system: NonlinearSystem, request: CurveRequest) -> ResponseCurve:
    """What `trace` ends with; nothing else of it is kept."""
    (whole,) = deque(trace(system, request), maxlen=1)
    return whole


def _traced(system: NonlinearSystem, request: CurveRequest) -> Iterator[ResponseCurve]:
    """As `trace`, all of the problem."""
    started = time.perf_counter()
    first = from_end(system, request, request.upwards, started)
    pieces = Pieces(first, from_end(system, request, not request.upwards, started))
    shown = first.records.curve()
    for _ in _advances(system, request, pieces, started):
        if not len(shown) <= len(first.records) < (1 + _COPIED) * len(shown):
            shown = first.records.curve()
        yield shown
    yield _finished(system, request, pieces)


def _advances(system: NonlinearSystem, request: CurveRequest, pieces: Pieces, started: float) -> Iterator[None]:
    """Until nothing more is to be traced: after every point of any segment."""
    while pieces.first.active and len(pieces.first.records) < request.assembly.from_one_end:
        if pieces.advance(pieces.first):
            yield
    yield from _from_both_ends(request, pieces)
    if pieces.connected and pieces.second.active and not _is_other_end(system, request, pieces.first):
        yield from _from_other_end(request, pieces)
    yield from _from_further_starts(system, request, pieces, started)


def _from_both_ends(request: CurveRequest, pieces: Pieces) -> Iterator[None]:
    """Both segments in turn, until they meet or have ended, or for long after they have covered the window."""
    both, left = (pieces.first, pieces.second), request.assembly.connecting
    while not pieces.connected and left > 0 and any(segment.active for segment in both):
        for segment in both:
            if segment.active and not pieces.connected:
                if not pieces.advance(segment):
                    continue
                # points up to where a segment turns back are not counted: that is as far as a sweep goes
                left -= segment.last is not segment.furthest and _covered(pieces)
                yield


def _is_other_end(system: NonlinearSystem, request: CurveRequest, segment: BranchSegment) -> bool:
    """Whether the solution from which a curve would begin at the other end of the window is on this segment, which has
    left there. The stuck response alone is tried: where none is found from it, it is not known."""
    w = 2 * np.pi * request.window[1 if segment.sign > 0 else 0]
    guess = linear_solution(system, w, request.excitation)
    solution = solve(system, request.excitation, guess, w, request.options.persistent)
    if not solution.converged or segment.traced is None:
        return True
    direction = (0 * solution.x, segment.sign)
    point = point_at(solution, request.excitation, request.options.scale_w(request.window), direction, 0.0)
    return segment.traced.leads_to(point)


def _from_other_end(request: CurveRequest, pieces: Pieces) -> Iterator[None]:
    """The second segment, until it has ended: by another branch, or by one beyond the window, it comes in where the
    first one has left."""
    for _ in range(request.assembly.connecting):
        if not pieces.second.active:
            return
        if pieces.advance(pieces.second):
            yield


def _covered(pieces: Pieces) -> bool:
    """Whether the segments from both ends have passed each other in frequency."""
    first, second = pieces.first.furthest, pieces.second.furthest
    return first is not None and second is not None and pieces.first.sign * (first.w - second.w) >= 0


def _from_further_starts(
    system: NonlinearSystem, request: CurveRequest, pieces: Pieces, started: float
) -> Iterator[None]:
    """Segments from starts between the open ends, in both directions, until the ends of the window are connected."""
    left = request.assembly.from_starts
    for _ in range(request.assembly.most_starts):
        if pieces.open_outside:  # nothing of the window is missing
            return
        ends = [end.traced for end in pieces.open_ends() if end.traced is not None]
        start = next((point for point in starts(system, request, ends) if not pieces.knows(point)), None)
        if start is None or not left:
            return
        pair = [segment_from(system, request, start, upwards, started) for upwards in (True, False)]
        pieces.add(start, *pair)
        for _ in range(min(request.assembly.connecting, left)):
            going = [segment for segment in pair if segment.active and not pieces.connected]
            if not going:
                break
            left -= 1
            for segment in going:
                if not pieces.connected and pieces.advance(segment):
                    yield


def _finished(system: NonlinearSystem, request: CurveRequest, pieces: Pieces) -> ResponseCurve:
    parts = [(part.segment.records, part.backwards, part.gap) for part in pieces.parts()]
    curve = cut_at_window(system, request, put_together(pieces.first.records, parts))
    curve = with_hardly_felt_resonances(system, request, curve)
    beside = within(request.window, (apart(pieces.first.records, *chain) for chain in pieces.detached()))
    scale_w = request.options.scale_w(request.window)
    curve = replace(curve, detached=tuple(one for one in beside if missing(curve, [middle(one)], scale_w)))
    limits = request.assembly.limits
    why = shortcoming(curve, request.window, limits, request.peaks_at[0])
    if why:
        ends = "; ".join(segment.end_sentence for segment in pieces.open_ends())
        return replace(curve, complete=False, stopped=f"{why}. {ends}")
    curve = with_extremes_solved(system, request, curve)
    why = unsettled(system, curve, limits.unsettled, request.assembly.settled_at)
    return replace(curve, complete=not why, stopped=why)
