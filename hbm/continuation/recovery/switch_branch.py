"""Branch switching at kinks: where a contact changes its state the branch may turn sharply, with no rounded top.

r(x, w) is one smooth function on this side of the kink and another on the far side. Where the branch turns by more than
a right angle no plane ahead of the kink is met by it, however small the step: it leaves the kink backwards. As in the
continuation of piecewise linear equations (Katzenelson 1965, Bell Syst. Tech. J. 44) the far side's own tangent tells
where it goes on. Its sense follows from the orientation (Eaves and Scarf 1976, Math. Oper. Res. 1): along a branch
the sign of det J times that of dw/ds stays, in folds and in kinks alike. With n the kink's normal the Jacobians of
both sides differ by a n^T alone, so that [J; n^T] has one determinant, and the branch crosses the kink the same way on
either side.

The kink is located between the last point and the shortest step that has failed. The direction beyond it holds until
the next kink, which may be as close as a contact's slip is small; so the steps tried from the kink fall by factors, and
one that has passed a further kink is known by its orientation. Contacts that mirror each other change their state
together, and the sign tells nothing there: of such problems half is solved (hbm/problem/mirror.py).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy.linalg

from updamp.hbm.continuation.branch import BranchPoint, branch_point
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Arc, Solution, solve

# Last points that a solution is compared with.
_LAST_POINTS = 12
# It lies on the branch through them where it is off that by no more than this share of its distance from the last
# point; the same for the mean position.
_OFF_BRANCH, _OFF_BRANCH_MEAN = 0.03, 0.3
# A mean position that moves by this share of the vibration for a unit of arc hardly moves.
_LITTLE_MEAN = 0.02


@dataclass(frozen=True)
class SwitchBranch:
    """A point in the direction in which the branch goes on beyond a kink.

    ahead: arc beyond the last point at which the far side is looked at, rising; up to `furthest`, or the last step but
        the smallest that may have failed: the kink lies within that step ahead of the last point
    located: how well the kink is, between two of these, by bisection [arc]: a tenth of the shortest step
    steps: arc beyond the kink, tried in turn
    no_kink: cosine between two tangents above which there is no kink between them; no_kink_mean: and change of their
        mean position, of which the metric sees little, relative to the larger, below which there is none
    straight: least cosine between the direction and the step that it has led to; longest: that step, by its length
    """

    ahead: tuple[float, ...] = (1e-9, 1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1)
    furthest: float = 1e-3
    located: float = 1e-8
    steps: tuple[float, ...] = (0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 1e-7)
    no_kink: float = 0.98
    no_kink_mean: float = 0.2
    straight: float = 0.7
    longest: float = 3.0

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        for place, direction in self.far_sides(corrector, traced.last):
            for step in self.steps:
                point = self._step(corrector, traced, place, direction, step)
                if point is not None:
                    return [point]
        return []

    def _step(
        self, corrector: Corrector, traced: TracedBranch, place: Move, direction: Move, step: float
    ) -> BranchPoint | None:
        """From the kink's place along the direction; its tangent is taken at the solution itself: that of the iterate
        before may be the other side's."""
        system, excitation, last = corrector.system, corrector.excitation, traced.last
        (x, w), (dx, dw) = place, direction
        arc = Arc(x + step * dx, w + step * dw, direction, last.metric)
        solution = solve(system, excitation, arc.x0, arc.w0, corrector.options.newton, arc)
        if not solution.converged:
            return None
        move = (solution.x - x, solution.w - w)
        length = last.metric.length(move)
        straight = last.metric.product(direction, move) > self.straight * length and length < self.longest * step
        off = last.metric.length((solution.x - arc.x0, solution.w - arc.w0))
        if not (straight and corrector.options.as_predicted(off, step)):
            return None
        point = branch_point(system, excitation, solution.x, solution.w, last.metric.scale_w, direction)
        if not _oriented_alike(point, last) or lies_on_last_points(traced.points, solution):
            return None
        return replace(point, step=last.distance(solution))

    def far_sides(self, corrector: Corrector, last: BranchPoint) -> Iterator[tuple[Move, Move]]:
        """The place (x, w) of the first kink ahead, with each direction in which the branch may go on beyond it: as it
        does at once, then as it does a little further on, where that is another one. Of unit length in the metric of
        the last point. None where there is no kink.

        A contact that opens for an instant, or begins to slip, may yield without limit at first (its tangent grows as
        one over the root of the distance); then the branch has turned on within less than any step."""
        orientation = _orientation(corrector, last)

        def beyond(ahead: float) -> Move | None:
            """The direction, if a kink lies before this place."""
            direction = _direction(corrector, last, ahead, orientation)
            return None if direction is None or self._goes_on(last, direction) else direction

        furthest = max(self.furthest, max(corrector.options.shortening) * corrector.options.smallest_step)
        here, direction = 0.0, None
        for there in (ahead for ahead in self.ahead if ahead <= furthest):
            if (found := beyond(there)) is None:
                here = there if direction is None else here
                continue
            if direction is None:
                at, direction = self._located(beyond, here, there, found)
                place = last.x + at * last.tangent_x, last.w + at * last.tangent_w
                yield place, direction
            if last.metric.product(direction, found) < self.no_kink:
                direction = found
                yield place, direction

    def _located(
        self, beyond: Callable[[float], Move | None], here: float, there: float, direction: Move
    ) -> tuple[float, Move]:
        """How far ahead the kink between two places is, and the direction just beyond it."""
        while there - here > self.located:
            middle = (here + there) / 2
            if (found := beyond(middle)) is None:
                here = middle
            else:
                there, direction = middle, found
        return there, direction

    def _goes_on(self, last: BranchPoint, direction: Move) -> bool:
        """Whether the direction is the last point's tangent, up to what an even bend may have changed."""
        sizes = [_mean_size(last, dx) for dx in (last.tangent_x, direction[0], direction[0] - last.tangent_x)]
        floor = _LITTLE_MEAN / last.metric.weights.max()
        same_mean = sizes[2] <= self.no_kink_mean * max(sizes[:2]) + floor
        return same_mean and last.metric.product(last.tangent, direction) > self.no_kink


def _orientation(corrector: Corrector, last: BranchPoint) -> float:
    """Of the last point; where its Jacobian was not factorised, it is now."""
    if last.orientation is not None:
        return last.orientation
    here = evaluate(corrector.system, corrector.excitation, last.x, last.w)
    return here.factorised().determinant_sign * float(np.sign(last.tangent_w))


def _direction(corrector: Corrector, last: BranchPoint, ahead: float, orientation: float) -> Move | None:
    """Of a branch with this orientation, as seen a little ahead of the last point; None where it has none."""
    x, w = last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w
    there = evaluate(corrector.system, corrector.excitation, x, w)
    try:
        jacobian = there.factorised()
    except scipy.linalg.LinAlgError:
        return None
    dx, dw = -jacobian.solve(there.frequency_derivative(corrector.excitation)), 1.0
    length = last.metric.length((dx, dw))
    if not 0 < length < np.inf:
        return None
    length = length if jacobian.determinant_sign == orientation else -length
    return dx / length, dw / length


def _oriented_alike(point: BranchPoint, last: BranchPoint) -> bool:
    """Where it is not known of one of them, no step tells."""
    return None in (point.orientation, last.orientation) or point.orientation == last.orientation


def lies_on_last_points(points: Sequence[BranchPoint], solution: Solution) -> bool:
    """Whether the solution lies on the branch between two of the last points, as their tangents bend it.

    Both sides of a sharp fold are close to each other: the solution counts as on the old one only where it is off it by
    far less than it is away from the last point, in the mean position too, of which the metric sees little.
    """
    last = points[-1]
    away, moved = last.distance(solution), _mean_size(last, solution.x - last.x)
    for a, b in pairwise(points[-_LAST_POINTS:]):
        if b.after_gap:
            continue
        off = _off_cubic(a, b, solution)
        if (
            off is not None
            and last.metric.length(off) < _OFF_BRANCH * away
            and _mean_size(last, off[0]) <= _OFF_BRANCH_MEAN * moved
        ):
            return True
    return False


def _mean_size(point: BranchPoint, dx: np.ndarray) -> float:
    """Of the mean position's move, which the metric hardly weighs."""
    harmonics = point.solution.equation.receptance.system.harmonics
    return float(np.linalg.norm(dx[:, harmonics.slices[0]])) if 0 in harmonics.orders else 0.0


def _off_cubic(a: BranchPoint, b: BranchPoint, solution: Solution) -> Move | None:
    """From the cubic between two points and their tangents to the solution; None if that lies beyond its ends."""
    (x, w), (off_x, off_w) = a.move_to(b), a.move_to(solution)
    length = b.metric.length((x, w))
    share = b.metric.product((x, w), (off_x, off_w)) / length**2
    if not -0.05 < share < 1.05:
        return None
    s = min(max(share, 0.0), 1.0)
    end = s**2 * (3 - 2 * s)
    start_slope = length * s * (1 - s) ** 2 / b.metric.length(a.tangent)
    end_slope = -length * s**2 * (1 - s) / b.metric.length(b.tangent)
    return (
        off_x - end * x - start_slope * a.tangent_x - end_slope * b.tangent_x,
        off_w - end * w - start_slope * a.tangent_w - end_slope * b.tangent_w,
    )
