"""Where a sweep lands after a jump: the branch from the other end of the window, as far as the fold's frequency.

Of a response with one hysteresis there are two stable parts beyond the fold: the one that the sweep has left, and the
one that the rest of the window belongs to. With more of them, one within another, a sweep could land on a part between,
which the way back along the whole branch would tell.
"""

from collections.abc import Callable, Iterable
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

    def begin(self, w: float) -> None:
        self.furthest, self.points, self.distance = self.sign * w, 0, 0.0

    def add(self, w: float) -> None:
        self.points += 1
        self.distance = self.furthest - self.sign * w

    def is_far(self, distance: float) -> bool:
        return self.points >= _MANY and self.distance > distance


def landing(
    other_end: OtherEnd, fold: FarBack, look: Callable[[BranchPoint], ObservedPoint], margin: int
) -> list[ObservedPoint]:
    """The branch from `margin` points before the fold's frequency to the other end of the window, in the order of the
    sweep; none where it turns back before, or cannot be followed.

    look: what is kept of a point
    """
    found: list[ObservedPoint] = []
    beyond, walk = 0, FarBack(-fold.sign)
    try:
        for point in other_end.points():
            found.append(look(point))
            if walk.leads_on(point.w):
                walk.begin(point.w)
            else:
                walk.add(point.w)
            beyond = 0 if fold.leads_on(point.w) else beyond + 1
            if beyond == margin:
                return turned_round(found)
            if walk.is_far(other_end.far):
                return []
    except BranchStoppedError:
        return []
    return []
