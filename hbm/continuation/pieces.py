"""The pieces of a branch and where they meet.

A branch is traced in segments: from both ends of the window, and from other starts in both directions. A segment whose
points run along another one, towards that one's beginning, is the same branch: the two are joined there, and what the
other traced beyond it is left out. Nothing else connects two points of a curve: where no segment leads from one to the
other the curve has a gap.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

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
        self, records: Records, sign: float, points: Iterator[BranchPoint], begun: Sequence[BranchPoint] = ()
    ) -> None:
        """points: still to come; begun: points that they follow, which are not recorded here"""
        self.records, self.sign, self.active = records, sign, True
        self.ended_by, self.left_at = "", 0
        self.furthest: BranchPoint | None = None
        self._points = points
        self.traced: TracedBranch | None = None
        self._numbers: list[int] = []  # of points recorded before the end of each chord that was traced
        for point in begun:
            self._extend(point)

    @property
    def last(self) -> BranchPoint | None:
        return self.traced.last if self.traced is not None else None

    @property
    def end_sentence(self) -> str:
        """Where and why it ended."""
        why = self.ended_by or "further points were not asked for (`CurveOptions.connecting`, `from_starts`)"
        return f"at {self.last.frequency:.6g} Hz: {why}" if self.last is not None else why

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
        return self.traced.chord_at(point, point.metric, point.step) if self.traced is not None else None

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
        self.end("it left the window" if self.left_at else inside)

    def _extend(self, point: BranchPoint) -> None:
        traced = TracedBranch([point]) if self.traced is None else self.traced.extended([point])
        if self.traced is not None and len(traced.chords) > len(self.traced.chords):
            self._numbers.append(len(self.records) - 1)
        self.traced = traced
        if self.furthest is None or self.sign * (point.w - self.furthest.w) > 0:
            self.furthest = point


@dataclass(frozen=True, eq=False)
class Part:
    """A segment of a chain. backwards: whether the chain runs against it; gap: whether nothing leads to it from the
    part before"""

    segment: BranchSegment
    backwards: bool = False
    gap: bool = False

    @property
    def empty(self) -> bool:
        return not len(self.segment.records)


class Pieces:
    """Segments and what joins them. It changes as they are traced.

    first, second: from either end of the window
    """

    def __init__(self, first: BranchSegment, second: BranchSegment) -> None:
        self.first, self.second = first, second
        self._same_start = first.records.request.assembly.same_start
        self.segments = [first, second]
        self._other_way: dict[BranchSegment, BranchSegment] = {}  # from the same start
        self._starts: list[BranchPoint] = []
        self._joint: dict[BranchSegment, BranchSegment] = {}  # the segment whose end this one's end is
        self._along: dict[BranchSegment, tuple[BranchSegment, int]] = {}  # chord on which the last point lay
        self._closed: set[BranchSegment] = set()  # that met the other one from their start
        self._known: set[BranchSegment] = set()  # that led to what another one had traced, and are not joined to it

    def add(self, start: BranchPoint, up: BranchSegment, down: BranchSegment) -> None:
        """Two segments from one start."""
        self._starts.append(start)
        self.segments += [up, down]
        self._other_way |= {up: down, down: up}

    def advance(self, moving: BranchSegment) -> bool:
        """The next point of an active segment; where it has met another one, they are joined and both end.

        returns: whether there was a further point
        """
        point = moving.next_point()
        if point is None:
            return False
        met, before = self._segment_at(moving, point), self._along.pop(moving, None)
        if met is not None:
            self._along[moving] = met
            # two points on chords of the other one: one alone may only cross it
            if before is not None and before[0] is met[0]:
                self._met(moving, met[0], before[1], towards_beginning=met[1] <= before[1])
        return True

    def knows(self, point: BranchPoint) -> bool:
        """Whether a start lies on what was traced, or is one that was tried."""
        tried = any(point.distance(start.solution) < self._same_start for start in self._starts)
        return tried or any(segment.chord_at(point) is not None for segment in self.segments)

    @property
    def connected(self) -> bool:
        """Whether one chain leads from one end of the window to the other, and nothing that comes in where it leaves
        goes out there again: that may be the same branch."""
        last = self._chain(self.first)[-1].segment
        if last is self.second:
            return True
        comes_back = self.second.left_at == self.first.sign and self.second not in self._known
        return last.left_at == self.first.sign and not comes_back

    def open_ends(self) -> Sequence[BranchSegment]:
        """The segments at which the chains from both ends of the window stop; none where they are one."""
        if self.connected:
            return ()
        last = (self._chain(segment)[-1] for segment in (self.first, self.second))
        return [part.segment for part in last]

    @property
    def open_outside(self) -> bool:
        """Whether the chains from both ends stop beyond the same end of the window, so that nothing of it lies between
        them."""
        return {segment.left_at for segment in self.open_ends()} in ({-1}, {1})

    def parts(self) -> Sequence[Part]:
        """In the order of the curve, from the first segment's end of the window to the other one, with what was found
        between the two chains where they are not one."""
        forwards = self._chain(self.first)
        if self.connected:
            return _with_points(forwards)
        backwards = self._chain(self.second)
        between = [chain for chain in self._others() if chain[0].segment not in self._closed]
        returned = [Part(part.segment, not part.backwards) for part in reversed(backwards)]
        chains = [forwards, *sorted(between, key=lambda c: self.first.sign * _middle(c)), returned]
        return [part for chain in chains for part in _after_gap(_with_points(chain))]

    def detached(self) -> Sequence[tuple[Sequence[Part], bool]]:
        """Chains that are no part of the curve, and whether each closes. While the window's ends are not connected,
        only those that close: of the others it is not known."""
        chains = [(_with_points(chain), chain[0].segment in self._closed) for chain in self._others()]
        return [
            (chain, closed) for chain, closed in chains
            if closed or (self.connected and not any(part.segment in self._known for part in chain))
        ]  # fmt: skip

    def _segment_at(self, moving: BranchSegment, point: BranchPoint) -> tuple[BranchSegment, int] | None:
        for other in self.segments:
            if other is not moving and (chord := other.chord_at(point)) is not None:
                return other, chord
        return None

    def _met(self, moving: BranchSegment, other: BranchSegment, chord: int, towards_beginning: bool) -> None:
        """Joined where the moving one runs towards the other's beginning. One from a further start that runs the same
        way as the other did finds nothing new; one from the window's end may come by where the other has stopped."""
        if not towards_beginning:
            if moving in self._other_way:
                moving.records.cut(len(moving.records) - 2)
                moving.end("it ran along what another segment had traced")
                self._known.add(moving)
            return
        taken = other in self._joint and self._leads_to_window(self._joint[other])
        moving.end("it met what another segment had traced")
        if self._other_way.get(moving) is other:
            moving.records.cut(len(moving.records) - 2)
            other.cut_at(chord)
            self._closed |= {moving, other}
            return
        if taken or self.connected:
            self._known.add(moving)
            return
        if (left := self._joint.pop(other, None)) is not None:
            del self._joint[left]
        other.cut_at(chord)
        moving.records.cut(len(moving.records) - 2)
        self._joint |= {moving: other, other: moving}

    def _leads_to_window(self, segment: BranchSegment) -> bool:
        """Whether the chain that a segment ends comes from an end of the window."""
        while (start := self._other_way.get(segment)) is not None:
            if start.left_at:
                return True
            if start not in self._joint:
                return False
            segment = self._joint[start]
        return True

    def _chain(self, start: BranchSegment) -> list[Part]:
        """From a segment's beginning along all that is joined to it."""
        parts, segment = [Part(start)], start
        while (joined := self._joint.get(segment)) is not None:
            parts.append(Part(joined, backwards=True))
            if (onwards := self._other_way.get(joined)) is None:
                break
            parts.append(Part(onwards))
            segment = onwards
        return parts

    def _others(self) -> Iterable[list[Part]]:
        """Chains of segments that are not on those from the window's ends, each once; a lone point is no branch."""
        from_ends = [self._chain(segment) for segment in (self.first, self.second)]
        if self.connected and self.second not in {part.segment for part in from_ends[0]}:
            del from_ends[1]  # a branch of its own from the other end
        known = {part.segment for chain in from_ends for part in chain}
        for segment in self.segments:
            if segment in known or segment in self._joint:
                continue
            onwards = self._other_way.get(segment)
            chain = [Part(segment, backwards=True), *(self._chain(onwards) if onwards else ())]
            known |= {part.segment for part in chain}
            if sum(len(part.segment.records) for part in chain) < 2:
                continue
            ends = [part.segment.last.w for part in (chain[0], chain[-1]) if part.segment.last is not None]
            if self.first.sign * (ends[-1] - ends[0]) < 0:
                chain = [Part(part.segment, not part.backwards) for part in reversed(chain)]
            yield chain


def _with_points(chain: Sequence[Part]) -> Sequence[Part]:
    return [part for part in chain if not part.empty]


def _after_gap(chain: Sequence[Part]) -> Sequence[Part]:
    return [Part(part.segment, part.backwards, gap=i == 0) for i, part in enumerate(chain)]


def _middle(chain: Sequence[Part]) -> float:
    """Of the frequencies of a chain's points [Hz]."""
    frequency = [f for part in chain for f in part.segment.records.columns["frequency"]]
    return (min(frequency) + max(frequency)) / 2
