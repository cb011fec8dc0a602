"""Where a sweep lands after a jump: the branch from the other end of the window, as far as the fold's frequency.

Of a response with one hysteresis there are two stable parts beyond the fold: the one that the sweep has left, and the
one that the rest of the window belongs to. With more of them, one within another, a sweep could land on a part between,
which the way back along the whole branch would tell.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.model.observed_point import ObservedPoint, turned_round
from updamp.hbm.branch import BranchPoint
from updamp.hbm.continuation import BranchStoppedError

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
