"""The points of a branch that a sweep sees, and a few beyond each of its folds.

Where the branch turns back the sweep jumps to the next part of it that leads on. What lies between is compared with
nothing, and in a wide hysteresis it is most of the branch: it is followed, but neither differentiated nor kept, nor
moved when parameters change.
"""

from collections import deque
from collections.abc import Callable, Iterable

import numpy as np

from updamp.diagnosis.model.observed_point import ObservedPoint
from updamp.hbm.branch import BranchPoint
from updamp.hbm.continuation import BranchStoppedError

# Points kept on either side of what is left out: parameters move folds along the branch.
_MARGIN = 4
# Points without which there is no branch.
_FEWEST = 4


def swept_points(
    branch: Iterable[BranchPoint], upwards: bool, look: Callable[[BranchPoint], ObservedPoint]
) -> tuple[list[ObservedPoint], str]:
    """In the order of the sweep, and why they end inside the window ("" where they do not).

    branch: its points, from where the sweep begins; look: what is kept of a point

    raises: BranchStoppedError where not even the first few are found
    """
    kept = _Kept(1.0 if upwards else -1.0, look)
    try:
        for point in branch:
            kept.add(point)
    except BranchStoppedError as stop:
        if kept.followed < _FEWEST:
            raise
        return kept.whole(), str(stop)
    return kept.whole(), ""


class _Kept:
    """What a sweep in the direction `sign` sees, and the margins of what it does not; followed: how many points."""

    def __init__(self, sign: float, look: Callable[[BranchPoint], ObservedPoint]) -> None:
        self._sign, self._look = sign, look
        self.followed, self._furthest, self._back = 0, -np.inf, 0
        self._points: list[ObservedPoint] = []
        self._lately: deque[BranchPoint] = deque(maxlen=_MARGIN)

    def add(self, point: BranchPoint) -> None:
        self.followed += 1
        ahead = self._sign * point.w
        if ahead > self._furthest:
            self._points = [*self.whole(), self._look(point)]
            self._furthest, self._back = ahead, 0
            self._lately.clear()
            return
        self._back += 1
        if self._back <= _MARGIN:
            self._points.append(self._look(point))
        else:
            self._lately.append(point)

    def whole(self) -> list[ObservedPoint]:
        """With the margin before what comes next."""
        margin = [self._look(point) for point in self._lately]
        if self._back > 2 * _MARGIN:
            margin[0] = margin[0].after_gap()
        return self._points + margin
