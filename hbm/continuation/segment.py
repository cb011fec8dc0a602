"""A segment of a branch: what is traced from one point in one direction, with what ended it."""

from collections.abc import Iterator, Sequence

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.continuation.curve_records import Records
from updamp.hbm.continuation.retracing import TracedBranch


class BranchSegment:
    """Traced in the direction `sign`: 1 upwards, -1 downwards at its start. It changes as it is traced, like any
    iterator.

    records: what is kept of its points; active: whether more are to come
    furthest: the point that came furthest in that direction
    ended_by: a sentence, "" while it is active; left_at: the side of the window at which it left, 1 above, -1 below, 0
        where it ended inside
    """

    def __init__(
        self, records: Records, sign: float, points: Iterator[BranchPoint], resumed: Sequence[BranchPoint] = ()
    ) -> None:
        """points: still to come; resumed: points that they follow and that are not recorded again"""
        self.records, self.sign, self.active = records, sign, True
        self.ended_by, self.left_at = "", 0
        self.furthest: BranchPoint | None = None
        self._points = points
        self._traced: TracedBranch | None = None
        self._numbers: list[int] = []  # of points recorded before the end of each chord that was traced
        for point in resumed:
            self._extend(point)

    @property
    def traced(self) -> TracedBranch | None:
        return self._traced

    @property
    def last(self) -> BranchPoint | None:
        return self._traced.last if self._traced is not None else None

    def next_point(self) -> BranchPoint | None:
        """The next point, recorded; None where the segment has ended."""
        try:
            point = next(self._points)
        except StopIteration:
            self._finish()
            return None
        except BranchStoppedError as stop:
            self.end(str(stop))
            return None
        self.records.add(point)
        self._extend(point)
        return point

    def chord_at(self, point: BranchPoint) -> int | None:
        """Number of this segment's chord on which a point of another segment lies."""
        return self._traced.chord_at(point, point.metric, point.step) if self._traced is not None else None

    def cut_at(self, chord: int) -> None:
        """Forget what was traced from the end of a chord on: it is another branch."""
        self.records.cut(self._numbers[chord])
        self.end("it was met by another segment")

    def end(self, reason: str) -> None:
        self.active, self.ended_by = False, self.ended_by or reason

    def _finish(self) -> None:
        """No more points: it has left the window, or they were too many."""
        (low, high), most = self.records.request.window, self.records.request.options.max_points
        at = self.last.frequency if self.last is not None else np.nan
        self.left_at = int(at > high) - int(at < low)
        inside = f"the end of the window was not reached in {most} points: raise max_points"
        self.end(f"it left the window at {at:.2f} Hz" if self.left_at else inside)

    def _extend(self, point: BranchPoint) -> None:
        traced = TracedBranch([point]) if self._traced is None else self._traced.extended([point])
        if self._traced is not None and len(traced.chords) > len(self._traced.chords):
            self._numbers.append(len(self.records) - 1)
        self._traced = traced
        if self.furthest is None or self.sign * (point.w - self.furthest.w) > 0:
            self.furthest = point
