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

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Solution
from updamp.hbm.problem.system import Forcing, NonlinearSystem

# Arc ahead of the last point at which the far side is looked at: one that is too short is still on this side, one that
# is too long has met the next kink.
_AHEAD = (1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1)
# The longest of them, or four times the smallest step: the kink lies within that step ahead of the last point.
_FURTHEST = 1e-3
# Steps on the far side, by that length: long enough to end beyond the kink, wherever before it the kink lies.
_STEPS, _LONGEST = (10.0, 3.0, 30.0), 0.01  # or ten times the smallest step
# Cosine between two tangents above which there is no kink between them.
_NO_KINK = 0.98
# Last points that a solution is compared with.
_LAST_POINTS = 12
# It lies on the branch through them where it is off that by no more than this share of its distance from the last
# point; the same for the mean position.
_OFF_BRANCH, _OFF_BRANCH_MEAN = 0.03, 0.3


@dataclass(frozen=True, eq=False)
class BranchDirection:
    """A direction, of unit length in the metric of the last point, in which the branch may go on.

    start: (x, w) beyond the kink; tangent: (dx, dw); steps: to try from there. A guess that began at the last point
    would lie on this side of the kink, where Newton's method finds the branch that led to it.
    """

    start: Move
    tangent: Move
    steps: tuple[float, ...]

    def reversed(self) -> "BranchDirection":
        return BranchDirection(self.start, (-self.tangent[0], -self.tangent[1]), self.steps)


def directions_beyond_kink(
    system: NonlinearSystem, excitation: Forcing, last: BranchPoint, smallest_step: float
) -> Iterator[BranchDirection]:
    """Directions of the branch beyond a kink close to `last`, with the orientation kept."""
    here = evaluate(system, excitation, last.x, last.w)
    orientation = here.factorised().determinant_sign * np.sign(last.tangent_w)
    for ahead in (length for length in _AHEAD if length <= max(_FURTHEST, 4 * smallest_step)):
        there = evaluate(system, excitation, last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w)
        try:
            jacobian = there.factorised()
        except scipy.linalg.LinAlgError:
            continue
        dx, dw = -jacobian.solve(there.frequency_derivative(excitation)), 1.0
        length = last.metric.length((dx, dw))
        if not 0 < length < np.inf or abs(last.metric.product(last.tangent, (dx, dw))) > _NO_KINK * length:
            continue
        length = length if jacobian.determinant_sign == orientation else -length
        steps = tuple(share * ahead for share in _STEPS if share * ahead <= max(_LONGEST, 10 * smallest_step))
        yield BranchDirection((there.x, there.w), (dx / length, dw / length), steps)


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
