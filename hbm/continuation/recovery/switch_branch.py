"""Branch switching at kinks: where a contact changes its state the branch may turn sharply, with no rounded top.

r(x, w) is one smooth function on this side of the kink and another on the far side. Where the branch turns by more than
a right angle no plane ahead of the kink is met by it, however small the step: it leaves the kink backwards. As in the
continuation of piecewise linear equations (Katzenelson 1965, Bell Syst. Tech. J. 44) the far side's own tangent tells
where it goes on. Its sense follows from the orientation (Eaves and Scarf 1976, Math. Oper. Res. 1): along a branch
the sign of det J times that of dw/ds stays, in folds and in kinks alike. With n the kink's normal the Jacobians of
both sides differ by a n^T alone, so that [J; n^T] has one determinant, and the branch crosses the kink the same way on
either side.

Where contacts that mirror each other change their state together the sign may change although the branch goes straight
on, as in any symmetric bifurcation; so the reversed direction is tried as well. Neither may lead back along the branch.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg

from updamp.hbm.continuation.branch import BranchPoint, point_after
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


@dataclass(frozen=True)
class SwitchBranch:
    """A point in the direction in which the branch goes on beyond a kink.

    reverse: with the orientation reversed
    ahead: arc beyond the last point at which the far side is looked at: one that is too short is still on this side,
        one that is too long has met the next kink; furthest: the longest of them, or four times the smallest step: the
        kink lies within that step ahead of the last point
    steps: on the far side, by that length: long enough to end beyond the kink, wherever before it the kink lies;
        longest: of them, or ten times the smallest step
    no_kink: cosine between two tangents above which there is no kink between them
    """

    reverse: bool = False
    ahead: tuple[float, ...] = (1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1)
    furthest: float = 1e-3
    steps: tuple[float, ...] = (10.0, 3.0, 30.0)
    longest: float = 0.01
    no_kink: float = 0.98

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        last, options = traced.last, corrector.options
        for direction in self.directions(corrector, last):
            (x, w), (dx, dw) = direction.start, direction.tangent
            for step in direction.steps:
                arc = Arc(x + step * dx, w + step * dw, direction.tangent, last.metric)
                solution = solve(corrector.system, corrector.excitation, arc.x0, arc.w0, options.newton, arc)
                if not solution.converged:
                    continue
                point = point_after(last, solution, corrector.excitation)
                straight = last.metric.product(direction.tangent, last.move_to(solution)) > 0.7 * point.step
                if straight and point.step < 3 * step and not lies_on_last_points(traced.points, solution):
                    return [point]
        return []

    def directions(self, corrector: Corrector, last: BranchPoint) -> "Iterator[BranchDirection]":
        """Of the branch beyond a kink close to `last`."""
        system, excitation, smallest = corrector.system, corrector.excitation, corrector.options.smallest_step
        here = evaluate(system, excitation, last.x, last.w)
        orientation = here.factorised().determinant_sign * np.sign(last.tangent_w)
        for ahead in (length for length in self.ahead if length <= max(self.furthest, 4 * smallest)):
            there = evaluate(system, excitation, last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w)
            try:
                jacobian = there.factorised()
            except scipy.linalg.LinAlgError:
                continue
            dx, dw = -jacobian.solve(there.frequency_derivative(excitation)), 1.0
            length = last.metric.length((dx, dw))
            if not 0 < length < np.inf or abs(last.metric.product(last.tangent, (dx, dw))) > self.no_kink * length:
                continue
            if (jacobian.determinant_sign == orientation) == self.reverse:
                length = -length
            steps = tuple(share * ahead for share in self.steps if share * ahead <= max(self.longest, 10 * smallest))
            yield BranchDirection((there.x, there.w), (dx / length, dw / length), steps)


@dataclass(frozen=True, eq=False)
class BranchDirection:
    """A direction, of unit length in the metric of the last point, in which the branch may go on.

    start: (x, w) beyond the kink; tangent: (dx, dw); steps: to try from there. A guess that began at the last point
    would lie on this side of the kink, where Newton's method finds the branch that led to it.
    """

    start: Move
    tangent: Move
    steps: tuple[float, ...]


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
