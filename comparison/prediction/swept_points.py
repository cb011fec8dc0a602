"""Where a sweep lands after a jump: the branch from the other end of the window, as far as the fold's frequency.

Of a response with one hysteresis there are two stable parts beyond the fold: the one that the sweep has left, and the
one that the rest of the window belongs to. With more of them, one within another, a sweep could land on a part between,
which the way back along the whole branch would tell.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from updamp.comparison.prediction.observed_point import ObservedPoint, turned_round
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError

# Points back from where a branch has turned round for it to be more than a corner of some contact's.
_MANY = 12
# Likewise, share of the window.
_FAR = 0.01


@dataclass(frozen=True)
class OtherEnd:
    """points: of the branch, from the end of the window that the sweep runs to; window: its width [rad/s]"""

    points: Callable[[], Iterable[BranchPoint]]
    window: float

    @property
    def far(self) -> float:
        """What counts as a long way back [rad/s]"""
        return _FAR * self.window


@dataclass
class FarBack:
    """How far a walk in the direction `sign` is behind the furthest frequency that it has reached.

    furthest: that, times the sign; points, distance: since then
    """

    sign: float
    furthest: float = -np.inf
    points: int = 0
    distance: float = 0.0

    def leads_on(self, w: float) -> bool:
        return self.sign * w > self.furthest

    def walk_to(self, w: float) -> None:
        if self.leads_on(w):
            self.furthest, self.points, self.distance = self.sign * w, 0, 0.0
        else:
            self.points += 1
            self.distance = self.furthest - self.sign * w

    def is_far(self, distance: float) -> bool:
        return self.points >= _MANY and self.distance > distance


class Landing:
    """The branch from the other end of the window, followed as far as it has been asked for, and no further than to
    where it turns back.

    look: what is kept of a point; margin: points kept before a fold's frequency
    """

    def __init__(
        self, other_end: OtherEnd, sign: float, look: Callable[[BranchPoint], ObservedPoint], margin: int
    ) -> None:
        self.far, self._look, self._margin = other_end.far, look, margin
        self._walk, self._way = iter(other_end.points()), FarBack(-sign)
        self._found: list[ObservedPoint] = []

    def at(self, fold: FarBack) -> list[ObservedPoint]:
        """From `margin` points before the fold's frequency to the other end, in the order of the sweep; none where it
        is not reached."""
        beyond = 0
        for n, point in enumerate(self._points(), 1):
            beyond = 0 if fold.leads_on(point.point.w) else beyond + 1
            if beyond == self._margin:
                return turned_round(self._found[:n])
        return []

    def _points(self) -> Iterator[ObservedPoint]:
        """Those followed before, then on from there."""
        yield from tuple(self._found)
        while not self._way.is_far(self.far):
            try:
                point = next(self._walk, None)
            except BranchStoppedError:
                return
            if point is None:
                return
            self._way.walk_to(point.w)
            self._found.append(self._look(point))
            yield self._found[-1]


# The points of a branch that a sweep sees, and a few beyond each of its folds.
#
# Where the branch turns back the sweep jumps to the next part of it that leads on. What lies between is compared with
# nothing, and in a wide hysteresis it is most of the branch, and the hardest to follow. So the part that the sweep
# jumps to is looked for from the other end of the window (`Landing`); where it is not found there, the way back is
# followed, but neither differentiated nor kept, nor moved when parameters change.

# Points kept on either side of what is left out: parameters move folds along the branch.
MARGIN = 4
# Points without which there is no branch.
_FEWEST = 4


def swept_points(
    branch: Iterable[BranchPoint],
    upwards: bool,
    look: Callable[[BranchPoint], ObservedPoint],
    other_end: OtherEnd | None = None,
) -> tuple[list[ObservedPoint], str]:
    """In the order of the sweep, and why they end inside the window ("" where they do not).

    branch: its points, from where the sweep begins; look: what is kept of a point; other_end: the branch from there

    raises: BranchStoppedError where not even the first few are found
    """
    sign = 1.0 if upwards else -1.0
    kept, ahead = _Kept(sign, look), Landing(other_end, sign, look, MARGIN) if other_end is not None else None
    try:
        for point in branch:
            kept.add(point)
            if ahead is not None and kept.way_back.is_far(ahead.far) and kept.land(ahead.at(kept.way_back)):
                break
    except BranchStoppedError as stop:
        if kept.followed < _FEWEST:
            raise
        if ahead is None or not kept.way_back.points or not kept.land(ahead.at(kept.way_back)):
            return kept.whole(), str(stop)
    return kept.whole(), ""


class _Kept:
    """What a sweep in the direction `sign` sees, and the margins of what it does not; followed: how many points."""

    def __init__(self, sign: float, look: Callable[[BranchPoint], ObservedPoint]) -> None:
        self._look, self.followed, self.way_back = look, 0, FarBack(sign)
        self._points: list[ObservedPoint] = []
        self._lately: deque[Callable[[], ObservedPoint]] = deque(maxlen=MARGIN)

    def add(self, point: BranchPoint) -> None:
        self._add(point.w, partial(self._look, point))

    def land(self, points: Sequence[ObservedPoint]) -> bool:
        """Go on with these, of another part of the branch, if there are any; of the way back the margin is kept."""
        if not points:
            return False
        self._lately.clear()
        self.way_back.points = min(self.way_back.points, MARGIN)
        for i, point in enumerate(points):
            there = point.after_gap() if i == 0 else point
            self._add(point.point.w, partial(_itself, there))
        return True

    def _add(self, w: float, look: Callable[[], ObservedPoint]) -> None:
        self.followed += 1
        if self.way_back.leads_on(w):
            self._points = [*self.whole(), look()]
            self.way_back.walk_to(w)
            self._lately.clear()
            return
        self.way_back.walk_to(w)
        if self.way_back.points <= MARGIN:
            self._points.append(look())
        else:
            self._lately.append(look)

    def whole(self) -> list[ObservedPoint]:
        """With the margin before what comes next."""
        margin = [look() for look in self._lately]
        if self.way_back.points > 2 * MARGIN:
            margin[0] = margin[0].after_gap()
        return self._points + margin


def _itself(point: ObservedPoint) -> ObservedPoint:
    return point
