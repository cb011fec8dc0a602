"""The points of a branch that a sweep sees, and a few beyond each of its folds.

Where the branch turns back the sweep jumps to the next part of it that leads on. What lies between is compared with
nothing, and in a wide hysteresis it is most of the branch, and the hardest to follow. So the part that the sweep jumps
to is looked for from the other end of the window (`landing.py`); where it is not found there, the way back is followed,
but neither differentiated nor kept, nor moved when parameters change.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from updamp.diagnosis.model.landing import FarBack, Landing, OtherEnd
from updamp.diagnosis.model.observed_point import ObservedPoint
from updamp.hbm.branch import BranchPoint
from updamp.hbm.continuation import BranchStoppedError

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
