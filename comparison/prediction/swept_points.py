"""The points of a branch that a sweep sees, and a few beyond each of its folds.

Where the branch turns back the sweep jumps to the next part of it that leads on. What lies between is compared with
nothing, and in a wide hysteresis it is most of the branch, and the hardest to follow. So the part that the sweep jumps
to is looked for from the far end of the window, as far as the fold's frequency; where it is not found there, the branch
is followed back, but neither differentiated nor kept, nor moved when parameters change.

Of a response with one hysteresis there are two stable parts beyond the fold: the one that the sweep has left, and the
one that the rest of the window belongs to. With more of them, one within another, a sweep could jump to a part between,
which only the whole branch would show.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from updamp.comparison.prediction.observed_point import ObservedPoint, turned_round
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError

# Points behind a fold from which on it is more than a corner that some contact's onset of slip makes.
_MANY = 12
# Likewise, share of the window.
_FAR = 0.01


@dataclass(frozen=True)
class BranchFromFarEnd:
    """The branch from the end of the window that the sweep runs to. points: yields them; window: its width [rad/s]"""

    points: Callable[[], Iterable[BranchPoint]]
    window: float

    @property
    def far(self) -> float:
        """Distance behind a fold that counts as far [rad/s]"""
        return _FAR * self.window


@dataclass
class DistanceBehindFold:
    """How far a branch followed in the direction `sign` has come back behind the furthest frequency that it reached.

    furthest: that frequency, times the sign [rad/s]; points, distance [rad/s]: since then
    """

    sign: float
    furthest: float = -np.inf
    points: int = 0
    distance: float = 0.0

    def is_ahead(self, w: float) -> bool:
        return self.sign * w > self.furthest

    def advance_to(self, w: float) -> None:
        if self.is_ahead(w):
            self.furthest, self.points, self.distance = self.sign * w, 0, 0.0
        else:
            self.points += 1
            self.distance = self.furthest - self.sign * w

    def is_far(self, distance: float) -> bool:
        return self.points >= _MANY and self.distance > distance


class BranchAfterJump:
    """The part of the branch that a sweep is on after a jump, followed from the far end of the window as far as it has
    been asked for, and no further than to where it turns back.

    observe: what is kept of a point; margin: points kept before a fold's frequency
    """

    def __init__(
        self, far_end: BranchFromFarEnd, sign: float, observe: Callable[[BranchPoint], ObservedPoint], margin: int
    ) -> None:
        self.far, self._observe, self._margin = far_end.far, observe, margin
        self._ahead, self._behind_fold = iter(far_end.points()), DistanceBehindFold(-sign)
        self._found: list[ObservedPoint] = []

    def beyond(self, fold: DistanceBehindFold) -> list[ObservedPoint]:
        """From `margin` points before the fold's frequency to the far end, in the order of the sweep; none where the
        fold's frequency is not reached."""
        beyond = 0
        for n, point in enumerate(self._points(), 1):
            beyond = 0 if fold.is_ahead(point.point.w) else beyond + 1
            if beyond == self._margin:
                return turned_round(self._found[:n])
        return []

    def _points(self) -> Iterator[ObservedPoint]:
        """Those followed before, then on from there."""
        yield from tuple(self._found)
        while not self._behind_fold.is_far(self.far):
            try:
                point = next(self._ahead, None)
            except BranchStoppedError:
                return
            if point is None:
                return
            self._behind_fold.advance_to(point.w)
            self._found.append(self._observe(point))
            yield self._found[-1]


# Points kept on either side of what is left out: parameters move folds along the branch.
MARGIN = 4
# Points without which there is no branch.
_FEWEST = 4


def swept_points(
    branch: Iterable[BranchPoint],
    upwards: bool,
    observe: Callable[[BranchPoint], ObservedPoint],
    far_end: BranchFromFarEnd | None = None,
) -> tuple[list[ObservedPoint], str]:
    """In the order of the sweep, and why they end inside the window ("" where they do not).

    branch: its points, from where the sweep begins; observe: what is kept of a point
    far_end: the branch from the end of the window that the sweep runs to

    raises: BranchStoppedError where not even the first few are found
    """
    sign = 1.0 if upwards else -1.0
    kept = _SweptPoints(sign, observe)
    ahead = BranchAfterJump(far_end, sign, observe, MARGIN) if far_end is not None else None
    try:
        for point in branch:
            kept.add(point)
            if (
                ahead is not None
                and kept.behind_fold.is_far(ahead.far)
                and kept.jump_to(ahead.beyond(kept.behind_fold))
            ):
                break
    except BranchStoppedError as stop:
        if kept.followed < _FEWEST:
            raise
        if ahead is None or not kept.behind_fold.points or not kept.jump_to(ahead.beyond(kept.behind_fold)):
            return kept.whole(), str(stop)
    return kept.whole(), ""


class _SweptPoints:
    """What a sweep in the direction `sign` sees, and the margins of what it does not; followed: how many points."""

    def __init__(self, sign: float, observe: Callable[[BranchPoint], ObservedPoint]) -> None:
        self._observe, self.followed, self.behind_fold = observe, 0, DistanceBehindFold(sign)
        self._points: list[ObservedPoint] = []
        self._lately: deque[Callable[[], ObservedPoint]] = deque(maxlen=MARGIN)

    def add(self, point: BranchPoint) -> None:
        self._add(point.w, partial(self._observe, point))

    def jump_to(self, points: Sequence[ObservedPoint]) -> bool:
        """Go on with these, of another part of the branch, if there are any; behind the fold the margin is kept."""
        if not points:
            return False
        self._lately.clear()
        self.behind_fold.points = min(self.behind_fold.points, MARGIN)
        for i, point in enumerate(points):
            there = point.after_gap() if i == 0 else point
            self._add(point.point.w, partial(_itself, there))
        return True

    def _add(self, w: float, look: Callable[[], ObservedPoint]) -> None:
        self.followed += 1
        if self.behind_fold.is_ahead(w):
            self._points = [*self.whole(), look()]
            self.behind_fold.advance_to(w)
            self._lately.clear()
            return
        self.behind_fold.advance_to(w)
        if self.behind_fold.points <= MARGIN:
            self._points.append(look())
        else:
            self._lately.append(look)

    def whole(self) -> list[ObservedPoint]:
        """With the margin before what comes next."""
        margin = [look() for look in self._lately]
        if self.behind_fold.points > 2 * MARGIN:
            margin[0] = margin[0].after_gap()
        return self._points + margin


def _itself(point: ObservedPoint) -> ObservedPoint:
    return point
