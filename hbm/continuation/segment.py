"""A segment of a branch: what is traced from one end of the window, with what ended it."""

from collections.abc import Iterator, Sequence

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.continuation.curve_records import Records
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.retracing import TracedBranch


class BranchSegment:
    """Traced in the direction `sign`: 1 upwards, -1 downwards. It changes as it is traced, like any iterator.

    records: what is kept of its points; active: whether more are to come; furthest: the point that came furthest
    ended_by: a sentence, "" while it is active; crossed_window: whether it left the window at the far end;
        out_of_points: whether it ended within the window for want of points
    """

    def __init__(
        self, records: Records, sign: float, points: Iterator[BranchPoint], resumed: Sequence[BranchPoint] = ()
    ) -> None:
        """points: still to come; resumed: the last ones of those that `records` has already"""
        self.records, self.sign, self.active = records, sign, True
        self.furthest: BranchPoint | None = None
        self.ended_by, self.crossed_window, self.out_of_points = "", False, False
        self._points = points
        self._traced: TracedBranch | None = None
        self._numbers: list[int] = []  # of points recorded before the end of each chord that was traced
        for point in resumed:
            self._extend(point)

    @property
    def last(self) -> BranchPoint | None:
        return self._traced.last if self._traced is not None else None

    def next_point(self) -> BranchPoint | None:
        """The next point, recorded; None where the segment has ended."""
        try:
            point = next(self._points)
        except StopIteration:
            self._finish("")
            return None
        except BranchStoppedError as stop:
            self._finish(str(stop))
            return None
        self.add(point)
        return point

    def add(self, point: BranchPoint) -> None:
        self.records.add(point)
        self._extend(point)

    def curve(self) -> ResponseCurve:
        """As far as it was traced; complete where it crossed the window."""
        return self.records.curve(complete=self.crossed_window)

    def chord_at(self, point: BranchPoint) -> int | None:
        """Number of this segment's chord on which a point of another segment lies."""
        return self._traced.chord_at(point, point.metric, point.step) if self._traced is not None else None

    def number_at(self, chord: int) -> int:
        """How many points were recorded before the end of a chord."""
        return self._numbers[chord]

    def _finish(self, stopped: str) -> None:
        """Once: what restarts add later, beyond its end, does not change what ended it."""
        self.active, self.ended_by = False, stopped
        (low, high), request = self.records.request.window, self.records.request
        if stopped or self.last is None:
            return
        at = self.last.frequency
        if low <= at <= high:
            self.out_of_points = True
            self.ended_by = (
                f"the end of the window was not reached in {request.options.max_points} points: raise max_points"
            )
        elif (at < low) == (self.sign > 0):
            self.ended_by = (
                f"the branch came back to {at:.2f} Hz, where it began: widen the window there or take smaller steps"
            )
        else:
            self.crossed_window, self.ended_by = True, f"it went through to {at:.2f} Hz"

    def _extend(self, point: BranchPoint) -> None:
        traced = TracedBranch([point]) if self._traced is None else self._traced.extended([point])
        if self._traced is not None and len(traced.chords) > len(self._traced.chords):
            self._numbers.append(len(self.records) - 1)
        self._traced = traced
        if self.furthest is None or self.sign * (point.w - self.furthest.w) > 0:
            self.furthest = point
