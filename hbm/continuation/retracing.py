"""Whether a point found ahead belongs to the branch: not on a part that was traced already, nor on another branch.

`TracedBranch` keeps what was traced, so that the branch does not run back over itself or round in circles.
`on_same_branch` asks whether the branch leads from its last point to the one that Newton's method has found,
`turn_between` by how much it turns between the two.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.metric import Metric

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BranchLimits:
    """When a point is on a branch.

    points_kept: as they are, to predict from; of the others only the chords between them
    before_chord: share of a chord by which a point may lie before its start; as near its end it is the next chord's
    off_chord: a point no further off a chord than this share of the chord, and of the step that led to it, is on it
    same_mean: two mean positions closer than this share of their size are the same
    bifurcation: steps up to this length may pass a bifurcation of a symmetric motion, where the orientation changes; in
        a longer one the change of orientation tells another branch
    symmetric: even harmonics of a motion without any, as a share of it: what Newton's method leaves of them
    ahead, straight: least cosine between tangent and move, of an ordinary step and of one through a bifurcation
    """

    points_kept: int = 60
    before_chord: float = 0.05
    off_chord: float = 0.1
    same_mean: float = 0.05
    bifurcation: float = 2e-3
    symmetric: float = 1e-8
    ahead: float = 0.3
    straight: float = 0.9


@dataclass(frozen=True, eq=False)
class Chord:
    """Between two neighbouring points (x, w) of a branch; orientation: that of its end, None where not known."""

    start: tuple[Floats, float]
    end: tuple[Floats, float]
    orientation: float | None


@dataclass(frozen=True, eq=False)
class TracedBranch:
    """points: the last ones, all but those added last without their equations; chords: between all neighbouring points,
    but for gaps"""

    points: Sequence[BranchPoint]
    chords: Sequence[Chord] = ()
    limits: BranchLimits = BranchLimits()

    @staticmethod
    def through(points: Sequence[BranchPoint]) -> "TracedBranch":
        return TracedBranch(points[:1]).extended(points[1:])

    @property
    def last(self) -> BranchPoint:
        return self.points[-1]

    def extended(self, points: Sequence[BranchPoint]) -> "TracedBranch":
        """By the points that follow the last one."""
        added, before = [], self.last
        for point in points:
            if not point.after_gap:
                added.append(Chord((before.x, before.w), (point.x, point.w), point.orientation))
            before = point
        kept = [*(point.without_equations() for point in self.points[-1:]), *points]
        kept = [*self.points[:-1], *kept][-self.limits.points_kept :]
        return replace(self, points=kept, chords=[*self.chords, *added])

    def contains(self, point: BranchPoint) -> bool:
        """Whether the point lies on a chord that was traced, not beyond the last point.

        The metric hardly sees the mean position; the same vibration about another mean position is another branch. So
        is the other side of a sharp fold: whoever goes back along a branch has the other orientation
        (hbm/continuation/recovery/switch_branch.py), and whoever goes back with the same one is on the fold's other
        side.
        """
        return self.chord_at(point, self.last.metric, self.last.distance(point)) is not None

    def leads_to(self, point: BranchPoint) -> bool:
        """Whether a point that was found by itself, without a step, lies on what was traced: on any chord, or at the
        end of the last one, which no other follows."""
        end = 1 + self.limits.before_chord
        return self.chord_at(point, point.metric, np.inf) is not None or (
            bool(self.chords) and _lies_on(self.chords[-1], point, point.metric, np.inf, self.limits, end)
        )

    def chord_at(self, point: BranchPoint, metric: Metric, step: float) -> int | None:
        """Number of the first chord that the point lies on; step: its distance from the one before [arc]"""
        reach, end = self.limits.off_chord * step * metric.scale_w, 1 - self.limits.before_chord
        for i, chord in enumerate(self.chords):
            low, high = sorted((chord.start[1], chord.end[1]))
            slack = reach + self.limits.before_chord * (high - low)
            if low - slack <= point.w <= high + slack and _lies_on(chord, point, metric, step, self.limits, end):
                return i
        return None


def _lies_on(chord: Chord, point: BranchPoint, metric: Metric, step: float, limits: BranchLimits, end: float) -> bool:
    """end: share of the chord from where on the point is none of its own"""
    (x, w) = chord.start
    along, off = (chord.end[0] - x, chord.end[1] - w), (point.x - x, point.w - w)
    length = metric.length(along)
    share = metric.product(along, off) / length**2
    if not -limits.before_chord < share < end:
        return False
    rest = (off[0] - share * along[0], off[1] - share * along[1])
    if metric.length(rest) > limits.off_chord * min(length, step):
        return False
    if float(np.linalg.norm(rest[0])) > limits.same_mean * float(np.linalg.norm(point.x)):
        return False
    if chord.orientation is None or point.orientation is None:
        return True
    back = metric.product(along, point.tangent) < 0
    return (chord.orientation == point.orientation) != back


def on_same_branch(last: BranchPoint, point: BranchPoint, limits: BranchLimits) -> bool:
    """Whether the branch runs from one to the other: ahead, and with its orientation kept
    (hbm/continuation/recovery/switch_branch.py).

    The response of a symmetric structure is symmetric, and goes straight on through bifurcations to asymmetric ones;
    the sign changes there. Without a symmetry to be broken it does not: a step that changes it, however short, has
    ended on another branch. Where it is costly to know, it is not asked for.
    """
    move = last.move_to(point)
    cosine = point.metric.product(point.tangent, move) / point.metric.length(move)
    before, after = last.orientation, point.orientation
    kept = before is None or after is None or before == after
    if kept:
        return cosine > limits.ahead
    return point.step < limits.bifurcation and cosine > limits.straight and _may_bifurcate(last, limits)


def _may_bifurcate(point: BranchPoint, limits: BranchLimits) -> bool:
    """Whether the motion may have a symmetry that a bifurcation breaks: the structure's mirror image, or that each half
    of the period is the other one turned over."""
    system, x = point.solution.equation.receptance.system, point.x
    even = [i for k, place in system.harmonics.slices.items() if k % 2 == 0 for i in range(place.start, place.stop)]
    turned_over = bool(even) and float(np.linalg.norm(x[:, even])) <= limits.symmetric * float(np.linalg.norm(x))
    return system.mirror is not None or turned_over


def turn_between(last: BranchPoint, point: BranchPoint) -> tuple[float, float]:
    """Angle between the tangents at both points [rad], and length of what they do not account for of the move [arc].

    A branch that turns in one kink, wherever between the two that lies, goes along the one tangent and then along the
    other. So a part along each, neither of them backwards, is taken off the move. What is left says that it has ended
    on another branch, or that the branch turns more than once on the way.
    """
    metric, (dx, dw), (x0, w0) = last.metric, last.move_to(point), last.tangent
    length = metric.length(point.tangent)
    x1, w1 = point.tangent_x / length, point.tangent_w / length
    cosine = metric.product((x0, w0), (x1, w1))
    along = np.array([metric.product((x0, w0), (dx, dw)), metric.product((x1, w1), (dx, dw))])
    first, second = (along - cosine * along[::-1]) / max(1 - cosine**2, np.finfo(float).eps)
    if min(first, second) < 0:  # along the nearer one alone
        first, second = along.clip(0.0) * (along == along.max())
    off = metric.length((dx - first * x0 - second * x1, dw - first * w0 - second * w1))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0))), off
