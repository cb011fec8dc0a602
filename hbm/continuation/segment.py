"""One piece of a curve, from one end of its window, while it is traced."""

from collections.abc import Iterator, Sequence

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.continuation.curve_records import Records
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.retracing import Traversed


class Leg:
    """A piece in the direction `sign`: 1 upwards, -1 downwards. It changes as it is traced, like any iterator.

    records: what is kept of its points; going: whether more are to come; furthest: the point that came furthest
    end: what ended it, as a sentence, "" where it goes on; through: whether it left the window at the far end then;
        exhausted: whether it ended within the window for want of points
    """

    def __init__(
        self, records: Records, sign: float, points: Iterator[BranchPoint], behind: Sequence[BranchPoint] = ()
    ) -> None:
        """points: still to come; behind: the last ones of those that `records` has already"""
        self.records, self.sign, self.going = records, sign, True
        self.furthest: BranchPoint | None = None
        self.end, self.through, self.exhausted = "", False, False
        self._points = points
        self._passed: Traversed | None = None
        self._numbers: list[int] = []  # of points recorded before the end of each piece of what was passed
        for point in behind:
            self._pass(point)

    @property
    def last(self) -> BranchPoint | None:
        return self._passed.last if self._passed is not None else None

    def step(self) -> BranchPoint | None:
        """The next point, recorded; None where the piece has ended."""
        try:
            point = next(self._points)
        except StopIteration:
            self._ends("")
            return None
        except BranchStoppedError as stop:
            self._ends(str(stop))
            return None
        self.add(point)
        return point

    def add(self, point: BranchPoint) -> None:
        self.records.add(point)
        self._pass(point)

    def curve(self) -> ResponseCurve:
        """As far as it was traced; complete where it went through the window."""
        return self.records.curve(complete=self.through)

    def piece_under(self, point: BranchPoint) -> int | None:
        """Number of the piece of this leg on which a point lies that was traced the other way round."""
        return self._passed.piece_under(point, point.metric, point.step) if self._passed is not None else None

    def number_at(self, piece: int) -> int:
        """How many points were recorded before the end of a piece."""
        return self._numbers[piece]

    def _ends(self, stopped: str) -> None:
        """Told once: what is added later, by new starts beyond its end, does not change what ended it."""
        self.going, self.end = False, stopped
        (low, high), request = self.records.request.window, self.records.request
        if stopped or self.last is None:
            return
        at = self.last.frequency
        if low <= at <= high:
            self.exhausted = True
            self.end = f"the end of the window was not reached in {request.options.max_points} points: raise max_points"
        elif (at < low) == (self.sign > 0):
            self.end = (
                f"the branch came back to {at:.2f} Hz, where it began: widen the window there or take smaller steps"
            )
        else:
            self.through, self.end = True, f"it went through to {at:.2f} Hz"

    def _pass(self, point: BranchPoint) -> None:
        passed = Traversed([point]) if self._passed is None else self._passed.then([point])
        if self._passed is not None and len(passed.pieces) > len(self._passed.pieces):
            self._numbers.append(len(self.records) - 1)
        self._passed = passed
        if self.furthest is None or self.sign * (point.w - self.furthest.w) > 0:
            self.furthest = point
