"""A curve traced from both ends of its window in turn, until the two segments meet.

Where a branch stops, turns back or winds for long, the other end often leads to the same place the short way: a segment
that went on along another branch at a kink is met where it still was on the right one. Where both segments stop with
frequencies between them that neither came to, these are crossed by restarts (hbm/continuation/restart.py).
"""

from collections.abc import Iterator

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.curve_records import CurveRequest
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.restart import AHEAD, Restart
from updamp.hbm.continuation.segment import BranchSegment
from updamp.hbm.problem.system import NonlinearSystem

# Arc between the ends of two segments up to which they count as one branch: about two ordinary steps.
_NEAR = 0.4
# And from which on there is nothing left between them.
_MET = 0.03


def from_both_ends(
    system: NonlinearSystem, request: CurveRequest, first: BranchSegment, second: BranchSegment
) -> Iterator[ResponseCurve]:
    """The curve so far, after every point; the last one is complete or says why it stopped.

    first: as far as it was traced, whether it is active or not; second: from the other end, not begun. What it finds is
    handed out when it is joined to the first. Where they cover the window and do not meet, the curve is complete, and
    the gap between them says that what connects them was not followed.
    """
    meetings = (_Meeting(second, first), _Meeting(first, second))
    left = request.connecting
    while (first.active or second.active) and left > 0:
        for meeting in meetings:
            if not meeting.moving.active:
                continue
            if meeting.after_next_point():
                yield first.records.joined(second.records, complete=True, gap=meeting.gap)
                return
            yield first.records.curve()
            # points up to where a segment turns back are not counted: that is as far as a sweep goes
            left -= meeting.moving.last is not meeting.moving.furthest and _covered(request, first, second)
        if first.crossed_window or second.crossed_window:
            break
    if first.crossed_window:
        yield first.curve()
        return
    complete = any(meeting.near for meeting in meetings)
    if not complete:
        yield from _restarted(system, request, first, second)
        # a restart no further ahead is known already: the other segment's end
        complete = _covered(request, first, second, AHEAD[-1]) and not (first.out_of_points or second.out_of_points)
    reason = f"{first.ended_by}. From the other end: {second.ended_by}"
    yield first.records.joined(second.records, complete=complete, stopped="" if complete else reason)


class _Meeting:
    """Whether the segment `moving` meets the other one, and what to keep of both then.

    gap: whether something between them was left out; near: whether it came near the place where the other stopped
    """

    def __init__(self, moving: BranchSegment, other: BranchSegment) -> None:
        self.moving, self.other = moving, other
        self.gap = True
        self._nearest = np.inf
        self._chord: int | None = None

    @property
    def near(self) -> bool:
        return self._nearest < _NEAR

    def after_next_point(self) -> bool:
        """Whether the two are one branch after the next point of the moving segment."""
        point = self.moving.next_point()
        if point is None:
            return False
        return self._runs_along(point) or self._reaches_the_end(point)

    def _runs_along(self, point: BranchPoint) -> bool:
        """Whether two points running lie on chords of the other one, towards its beginning: one may only cross it.

        The branch is then the other segment up to there, and this one without these two; what the other traced after it
        is another branch.
        """
        before, self._chord = self._chord, self.other.chord_at(point)
        if before is None or self._chord is None or self._chord > before:
            return False
        self.other.records.cut(self.other.number_at(before))
        self.moving.records.cut(len(self.moving.records) - 2)
        self.gap = False
        return True

    def _reaches_the_end(self, point: BranchPoint) -> bool:
        """Whether the point is the last one before it leads away again from where the other one has stopped."""
        if self.other.active or self.other.last is None:
            return False
        apart = self.other.last.distance(point)
        if self.near and apart > self._nearest:
            self.moving.records.cut(len(self.moving.records) - 1)
            return True
        self._nearest = apart
        return apart < _MET


def _restarted(
    system: NonlinearSystem, request: CurveRequest, first: BranchSegment, second: BranchSegment
) -> Iterator[ResponseCurve]:
    """Restarts between two segments: from the first one's end on, and if they do not come to the second one's, from
    there on towards the first.
    """
    for growing, other in ((first, second), (second, first)):
        if growing.furthest is None or _covered(request, first, second):
            continue
        until = other.furthest.w if other.furthest is not None else 2 * np.pi * _limit(request, growing.sign)
        restart = Restart(system, request.excitation, request.window, request.options, growing.sign, until)
        for point in restart.points(growing.furthest):
            growing.add(point)
            yield first.records.curve()


def _limit(request: CurveRequest, sign: float) -> float:
    """End of the window in that direction [Hz]"""
    return request.window[1] if sign > 0 else request.window[0]


def _covered(request: CurveRequest, first: BranchSegment, second: BranchSegment, but_for: float = 0.0) -> bool:
    """Whether the segments leave out no more than a share of the window between them."""
    reached = [
        2 * np.pi * _limit(request, -segment.sign) if segment.furthest is None else segment.furthest.w
        for segment in (first, second)
    ]
    width = 2 * np.pi * (request.window[1] - request.window[0])
    return first.sign * (reached[1] - reached[0]) <= but_for * width
