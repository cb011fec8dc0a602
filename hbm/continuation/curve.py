"""Trace a response curve: continuation, with what is to be kept of every point.

Most curves are one segment, from one end of the window to the other. Where that one stops, or winds for long, the
curve is traced from the other end too, until the two meet; where they do not, from further starts between their ends,
in both directions (hbm/continuation/pieces.py).
"""

import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, branch_point
from updamp.hbm.continuation.completeness import shortcoming
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.continuation.curve_records import CurveRequest, Records, put_together
from updamp.hbm.continuation.extremes import with_extremes_solved
from updamp.hbm.continuation.pieces import BranchSegment, Pieces
from updamp.hbm.continuation.predictor_corrector import CONNECTED
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.starts import starts
from updamp.hbm.problem.system import NonlinearSystem

__all__ = ["CurveRequest", "trace", "whole_curve"]

# Growth after which a curve that is being traced is copied again, as a share of its points: n points one by one would
# be n^2 / 2 of them.
_COPIED = 0.01


def trace(
    system: NonlinearSystem, request: CurveRequest, resume_from: ResponseCurve | None = None
) -> Iterator[ResponseCurve]:
    """The curve so far, after every point; the last one handed out is `complete` or says why it `stopped`.

    Of a problem that is its own mirror image half is solved (hbm/problem/mirror.py), and `active` counts its rows.
    Beyond a hundred points a curve is handed out again until it has grown by a hundredth: it is copied as a whole.

    resume_from: an interrupted curve of the same system and request; only what follows it is solved
    raises: nothing; a branch that cannot go on ends the curve with its sentence in `stopped`
    """
    row = request.excitation.row
    if (driven := system.half_driven_at(row)) is None:
        yield from _traced(system, request, resume_from)
        return
    half, mirror = driven
    excitation = replace(request.excitation, row=row - system.free.n_relative + half.free.n_relative)
    if resume_from is not None and len(resume_from):
        resume_from = replace(resume_from, displacement=mirror.halved(resume_from.displacement))
    shown = whole = None
    for curve in _traced(half, replace(request, excitation=excitation), resume_from):
        if whole is None or curve is not shown:
            shown = curve
            whole = replace(curve, displacement=mirror.whole(curve.displacement)) if len(curve) else curve
        yield whole


def whole_curve(system: NonlinearSystem, request: CurveRequest) -> ResponseCurve:
    """What `trace` ends with; nothing else of it is kept."""
    (whole,) = deque(trace(system, request), maxlen=1)
    return whole


def _traced(
    system: NonlinearSystem, request: CurveRequest, resume_from: ResponseCurve | None
) -> Iterator[ResponseCurve]:
    """As `trace`, all of the problem."""
    started = time.perf_counter()
    if resume_from is not None and (resume_from.complete or resume_from.stopped):
        yield resume_from
        return
    earlier = resume_from if resume_from is not None and len(resume_from) >= 2 else None
    first = _segment(system, request, request.upwards, started, earlier)
    pieces = Pieces(first, _segment(system, request, not request.upwards, started))
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
        ends = [end.traced for end in pieces.open_ends() if end.traced is not None]
        start = next((point for point in starts(system, request, ends) if not pieces.knows(point)), None)
        if start is None or not left:
            return
        pair = [_segment_from(system, request, start, upwards, started) for upwards in (True, False)]
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
    curve = put_together(pieces.first.records, parts)
    why = shortcoming(curve, request.window, request.assembly.limits)
    curve = curve if why else with_extremes_solved(system, request, curve)
    ends = "; ".join(segment.end_sentence for segment in pieces.open_ends())
    return replace(curve, complete=not why, stopped=f"{why}. {ends}" if why else "")


def _segment(
    system: NonlinearSystem, request: CurveRequest, upwards: bool, started: float, earlier: ResponseCurve | None = None
) -> BranchSegment:
    """From the lower end of the window (upwards) or the upper one; earlier: what there is of it"""
    resumed = _last_points(system, request, earlier) if earlier is not None else ()
    points = _followed(system, request, upwards, resumed)
    return BranchSegment(Records(system, request, started, earlier), 1.0 if upwards else -1.0, points, resumed)


def _segment_from(
    system: NonlinearSystem, request: CurveRequest, start: BranchPoint, upwards: bool, started: float
) -> BranchSegment:
    """From a start that the segment upwards records, and the other one does not."""
    sign = 1.0 if upwards else -1.0
    if np.sign(start.tangent_w) != sign:
        start = start.turned()
    points = _followed(system, request, upwards, [start])
    records = Records(system, request, started)
    if upwards:
        records.add(replace(start, after_gap=False))
    return BranchSegment(records, sign, points, [start])


def _followed(
    system: NonlinearSystem, request: CurveRequest, upwards: bool, resumed: Sequence[BranchPoint]
) -> Iterator[BranchPoint]:
    """Without jumps: where the branch cannot be followed, other segments lead on."""
    options = replace(request.options, recoveries=CONNECTED)
    return continue_branch(system, request.excitation, request.window, options, upwards, resumed)


def _last_points(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> Sequence[BranchPoint]:
    """The last two points of a stored curve as points of a branch, tangents computed anew."""
    scale_w = request.options.scale_w(request.window)
    places = [(curve.displacement[i], 2 * np.pi * curve.frequency[i]) for i in (-2, -1)]
    direction = (places[1][0] - places[0][0], places[1][1] - places[0][1])
    return [branch_point(system, request.excitation, x, w, scale_w, direction) for x, w in places]
