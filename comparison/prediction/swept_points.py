"""The parts of a branch that a sweep may be on, and a few points beyond each of its folds.

Where the branch turns back the sweep jumps to the next part of it that leads on, or before, when something disturbs it;
and a sweep that begins where there are two parts may begin on either. What lies between the two is compared with
nothing, and in a wide hysteresis it is the hardest to follow. So the part that the sweep jumps to is looked for from
the far end of the window, up to where it turns back itself; where it is not found there, the branch is followed back,
but what runs against the sweep is neither differentiated nor kept, nor moved when parameters change.

Where the branch does not turn back inside the window, the window may still end inside a hysteresis: then the far end
stands on another part, which a sweep that began there is on, and which is kept up to where it turns back.

Of a response with one hysteresis there are two stable parts beyond the fold: the one that the sweep has left, and the
one that the rest of the window belongs to. With more of them, one within another, a sweep could jump to a part between,
which only the whole branch would show.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from updamp.comparison.prediction.observed_point import ObservedPoint, turned_round
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError

Observe = Callable[[Sequence[BranchPoint]], list[ObservedPoint]]
# Points kept on either side of what is left out: parameters move folds along the branch.
MARGIN = 4
# Points followed before what the first of them shows is asked for: together they take less time, and those that a sweep
# jumps from are for nothing.
_AHEAD = 8
# Share of the window that a branch has to come back behind a fold for it to be more than a corner that some contact's
# onset of slip makes.
_FAR = 0.01
# A point on a piece of a branch is no farther from either end of it than the piece is long; half as far again it is
# beside it.
_BESIDE = 1.5


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
        return self.points >= MARGIN and self.distance > distance


class BranchAfterJump:
    """The part of the branch that a sweep is on after a jump, followed from the far end of the window to where it turns
    back.

    observe: what is kept of points
    margin: points kept before a fold's frequency, or from where the part turns back on
    """

    def __init__(
        self,
        far_end: BranchFromFarEnd,
        sign: float,
        observe: Observe,
        margin: int,
    ) -> None:
        self.far, self._sign, self._margin = far_end.far, sign, margin
        self._end, self._observe = far_end, observe

    def beyond(self, fold: DistanceBehindFold) -> list[ObservedPoint]:
        """From `margin` points before the fold's frequency to the far end, in the order of the sweep, or from where
        the part begins, if a run may begin there; none where the fold's frequency is not reached."""
        beyond = [not fold.is_ahead(o.point.w) for o in self._followed]
        reached = next((n for n in range(self._margin, len(beyond) + 1) if all(beyond[n - self._margin : n])), 0)
        if not reached:
            return []
        return self._up_to_fold(reached)

    def beside(self, branch: Sequence[BranchPoint]) -> list[ObservedPoint]:
        """The same from where the part turns back to the far end, where that is not on the branch that ends there.

        branch: its points, up to the last one
        """
        with suppress(BranchStoppedError):
            if not self._is_on(branch):
                return self._up_to_fold()
        return []

    def _is_on(self, branch: Sequence[BranchPoint]) -> bool:
        """Whether the far end is on the branch. Either may begin farther outside the window than the other one: that
        one has a piece on which the first point of the other is to be. A far end that turns back before comes to
        nothing that a sweep in the window could be on.

        raises: BranchStoppedError as the far end's points do
        """
        last, behind_fold = branch[-1], DistanceBehindFold(-self._sign)
        if any(self._sign * point.w > self._sign * last.w for point in branch):
            return False  # it has turned back, and left the window at the end that it had come in by
        before: BranchPoint | None = None
        for point in self._end.points():
            behind_fold.advance_to(point.w)
            if self._sign * point.w <= self._sign * last.w:
                return _lies_on(last, before, point) if before is not None else self._is_on_a_piece(point, branch)
            if behind_fold.is_far(self.far):
                break
            before = point
        return True

    def _is_on_a_piece(self, point: BranchPoint, branch: Sequence[BranchPoint]) -> bool:
        """Of the branch, the last one that its frequency is within"""
        pieces = zip(reversed(branch[:-1]), reversed(branch[1:]), strict=True)
        around = ((a, b) for a, b in pieces if self._sign * a.w <= self._sign * point.w)
        return _lies_on(point, *next(around, branch[-2:]))

    def _up_to_fold(self, least: int = 0) -> list[ObservedPoint]:
        """With a margin behind the fold, in the order of the sweep; least: points"""
        ahead = [self._sign * o.point.w for o in self._followed]
        return turned_round(self._followed[: max(int(np.argmin(ahead)) + self._margin, least)])

    @cached_property
    def _followed(self) -> list[ObservedPoint]:
        """From the far end."""
        found: list[ObservedPoint] = []
        behind_fold = DistanceBehindFold(-self._sign)
        with suppress(BranchStoppedError):
            for points in _some_at_a_time(self._end.points()):
                for seen in self._observe(points):
                    behind_fold.advance_to(seen.point.w)
                    found.append(seen)
                    if behind_fold.is_far(self.far):
                        return found
        return found


def _lies_on(point: BranchPoint, *piece: BranchPoint) -> bool:
    """Whether a point is on a piece of a branch, from one point to the next."""
    start, end = piece
    return max(point.distance(start), point.distance(end)) <= _BESIDE * start.distance(end)


# Points without which there is no branch.
_FEWEST = 4


def swept_points(
    branch: Iterable[BranchPoint],
    upwards: bool,
    observe: Observe,
    far_end: BranchFromFarEnd | None = None,
) -> tuple[list[ObservedPoint], str]:
    """In the order of the sweep, and why they end inside the window ("" where they do not).

    branch: its points, from where the sweep begins; observe: what is kept of points
    far_end: the branch from the end of the window that the sweep runs to

    raises: BranchStoppedError where not even the first few are found
    """
    sign = 1.0 if upwards else -1.0
    kept = _SweptPoints(sign, observe)
    ahead = BranchAfterJump(far_end, sign, observe, MARGIN) if far_end is not None else None
    try:
        for passed in _passed(branch, sign, observe):
            kept.add(passed)
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
    if ahead is not None and not kept.jumped:
        kept.add_beside(ahead.beside([seen.point for seen in kept.whole()]))
    return kept.whole(), ""


class _SweptPoints:
    """What sweeps in the direction `sign` may see, and the margins of what they do not; followed: how many points."""

    def __init__(self, sign: float, observe: Observe) -> None:
        self._observe, self.followed, self.behind_fold = observe, 0, DistanceBehindFold(sign)
        self._points: list[ObservedPoint] = []
        self._lately: list[_Passed] = []
        self.jumped = False

    def jump_to(self, points: Sequence[ObservedPoint]) -> bool:
        """Go on with these, of another part of the branch, if there are any; behind the fold the margin is kept."""
        if not points:
            return False
        self.jumped = True
        self._lately.clear()
        self.behind_fold.points = min(self.behind_fold.points, MARGIN)
        for i, seen in enumerate(points):
            there = seen if i else seen.after_gap()
            self.add(_Passed(there.point, there))
        return True

    def add_beside(self, points: Sequence[ObservedPoint]) -> None:
        """Another part of the branch, none of which this sweep comes to; what is behind a fold ends here."""
        self._points = [*self.whole(), *(seen if i else seen.after_gap() for i, seen in enumerate(points))]
        self._lately.clear()
        self.behind_fold.points = 0

    def add(self, passed: "_Passed") -> None:
        self.followed += 1
        if self.behind_fold.is_ahead(passed.point.w):
            self._points = [*self.whole(), passed.seen_by(self._observe)]
            self.behind_fold.advance_to(passed.point.w)
            self._lately.clear()
            return
        self.behind_fold.advance_to(passed.point.w)
        if self.behind_fold.points <= MARGIN:
            self._points.append(passed.seen_by(self._observe))
            return
        self._lately.append(passed)
        # seen at once: the matrices of a whole stretch are large
        stretch = [_Passed(p.point, p.seen_by(self._observe)) for p in self._stretch()]
        self._lately = [*self._lately[: len(self._lately) - len(stretch)][-MARGIN:], *stretch]

    def _stretch(self) -> list["_Passed"]:
        """Those of the last points behind a fold that run with the sweep."""
        points = [passed.point for passed in self._lately]
        ahead = [self.behind_fold.sign * point.w for point in points]
        begins = len(points) - 1
        while begins and not points[begins].after_gap and ahead[begins - 1] < ahead[begins]:
            begins -= 1
        return self._lately[begins:] if begins < len(points) - 1 else []

    def whole(self) -> list[ObservedPoint]:
        """With what is kept before what comes next."""
        margin = [passed.seen_by(self._observe) for passed in self._lately]
        if self.behind_fold.points > MARGIN + len(margin):
            margin[0] = margin[0].after_gap()
        return self._points + margin


@dataclass(frozen=True, eq=False)
class _Passed:
    """A point of the branch, and what is kept of it, once it has been observed."""

    point: BranchPoint
    seen: ObservedPoint | None = None

    def seen_by(self, observe: Observe) -> ObservedPoint:
        return observe([self.point])[0] if self.seen is None else self.seen


def _passed(branch: Iterable[BranchPoint], sign: float, observe: Observe) -> Iterator[_Passed]:
    """Its points. Those that run ahead with the sweep are observed, some at a time; of a branch that is there already,
    which was kept as what a sweep may see, all."""
    if isinstance(branch, Sequence):
        yield from (_Passed(seen.point, seen) for seen in observe(branch))
        return
    fold = DistanceBehindFold(sign)
    for points in _some_at_a_time(branch):
        ahead = []
        for point in points:
            ahead.append(fold.is_ahead(point.w))
            fold.advance_to(point.w)
        seen = iter(observe([p for p, is_ahead in zip(points, ahead, strict=True) if is_ahead]))
        yield from (_Passed(p, next(seen) if is_ahead else None) for p, is_ahead in zip(points, ahead, strict=True))


def _some_at_a_time(branch: Iterable[BranchPoint]) -> Iterator[list[BranchPoint]]:
    """raises: BranchStoppedError as the branch does, after the points before"""
    some: list[BranchPoint] = []
    try:
        for point in branch:
            some.append(point)
            if len(some) == _AHEAD:
                yield some
                some = []
    except BranchStoppedError:
        if some:
            yield some
        raise
    if some:
        yield some
