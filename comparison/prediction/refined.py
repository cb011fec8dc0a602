"""Points put between those of a branch until what is interpolated between them is as good as the measurement asks for.

Steps of a continuation are chosen for Newton's method. Where contacts begin to slip the branch bends at once, and the
cubic between two points cuts the corner, by as much as what is measured scatters. Each point tells how far the cubic
between its neighbours would have been off: where that is too much, points are put between until they lie where the
cubic has them. So what is compared does not depend on where a branch happens to have its points.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.numerical_error import to_nearest_turn
from updamp.comparison.prediction.observed_point import ObservedPoint
from updamp.comparison.prediction.predicted_branch import length_of, logarithms
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.hbm.continuation.branch import BranchPoint, point_after
from updamp.hbm.newton.newton import Arc, NewtonOptions, solve_together
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
# From pairs of points to the solved one half way between each two, None where there is none
Between = Callable[[Sequence[tuple[ObservedPoint, ObservedPoint]]], Sequence[ObservedPoint | None]]

# Derivatives of a fit need no more.
NEWTON = NewtonOptions(tolerance=1e-7, iterations=10, patience=4)
# A point put between two others has to be nearer to both than this share of their distance.
_BETWEEN = 0.8
# Places tried on a cubic for the one nearest to a point, and steps of Gauss-Newton from there.
_TRIED, _STEPS = 33, 3


@dataclass(frozen=True)
class InterpolationOptions:
    """error: expected of what is interpolated, across the branch and in standard deviations of the measurement. If all
        of 500 values were as far off, chi-square would be off by 4.5 at one standard deviation; at corners it is up to
        twice as much, elsewhere far less, and found was 0.1
    smooth, left: share of a cubic's error that is left once a point has been put between: a sixteenth where the branch
        is smooth, a half where it turns a corner
    halvings: of the distance between two points, at most
    """

    error: float = 0.1
    smooth: float = 1 / 16
    left: float = 0.5
    halvings: int = 8


def refined(points: Sequence[ObservedPoint], condition: RunCondition, between: Between) -> list[ObservedPoint]:
    """The same points and those put between them; as they are where the condition does not know of any noise."""
    if not condition.noise or len(points) < 3:
        return list(points)
    pieces = _pieces(points, condition)
    for _ in range(InterpolationOptions.halvings):
        wide = [piece for piece in pieces if piece.error > InterpolationOptions.error]
        if not wide:
            break
        middles = between([(piece.start, piece.end) for piece in wide])
        halves = dict(zip(map(id, wide), _halved(wide, middles, condition), strict=True))
        pieces = [half for piece in pieces for half in halves.get(id(piece), (piece,))]
    return [points[0], *(piece.end for piece in pieces)]


@dataclass(frozen=True, eq=False)
class _Piece:
    """Of a branch between two points; error: expected of the cubic between them; left: share of that that each of the
    halves is expected to be off by"""

    start: ObservedPoint
    end: ObservedPoint
    error: float
    left: float


def _halved(
    wide: Sequence[_Piece],
    middles: Sequence[ObservedPoint | None],
    condition: RunCondition,
) -> list[tuple[_Piece, ...]]:
    """Each by the point half way, or as it is, and right, where there is none."""
    split = [(piece, middle) for piece, middle in zip(wide, middles, strict=True) if middle is not None]
    found: Iterator[float] = iter(())
    if split:
        starts, given, ends = zip(*((piece.start, middle, piece.end) for piece, middle in split), strict=True)
        found = iter(deviation(starts, given, ends, condition).tolist())
    halves: list[tuple[_Piece, ...]] = []
    for piece, middle in zip(wide, middles, strict=True):
        if middle is None:
            halves.append((replace(piece, error=0.0),))
            continue
        # a cubic may happen to be right half way: by one look neither what is expected nor its share falls farther
        seen = max(next(found), piece.left * piece.error)
        left = max(piece.left, _share(seen, piece.error / piece.left))
        error = left * seen
        halves.append((_Piece(piece.start, middle, error, left), _Piece(middle, piece.end, error, left)))
    return halves


def _pieces(points: Sequence[ObservedPoint], condition: RunCondition) -> list[_Piece]:
    """Between neighbours, with what is to be expected of the cubics between them from those that leave out points."""
    near, far = (_beside(points, condition, reach) for reach in (1, 2))
    unmeasured = _unmeasured(points, condition)
    found = []
    for i, (a, b) in enumerate(pairwise(points)):
        left = _share(near[i], far[i])
        error = 0.0 if unmeasured[i] or b.point.after_gap else left * near[i]
        found.append(_Piece(a, b, error, left))
    return found


def _share(near: float, far: float) -> float:
    """What is left of a cubic's error with half its length: as much as from one twice as long to it"""
    least, most = InterpolationOptions.smooth, InterpolationOptions.left
    return float(np.clip(near / far, least, most)) if far > 0 else most


def _beside(points: Sequence[ObservedPoint], condition: RunCondition, reach: int) -> Floats:
    """(n - 1,) how far cubics are off at a point that they leave out, from `reach` points before it to as many after,
    the larger of the two for each pair of neighbours; none where there is a gap between."""
    off = np.zeros(len(points))
    if len(points) > 2 * reach:
        off[reach:-reach] = deviation(points[: -2 * reach], points[reach:-reach], points[2 * reach :], condition)
    gaps = np.flatnonzero([o.point.after_gap for o in points])
    for i in range(-reach, reach):
        off[np.clip(gaps + i, 0, len(off) - 1)] = 0.0
    return np.asarray(np.maximum(off[:-1], off[1:]))


def _unmeasured(points: Sequence[ObservedPoint], condition: RunCondition) -> NDArray[np.bool_]:
    """(n - 1,) whether a point and the next lie on the same side outside the measured window."""
    frequency = np.array([o.point.frequency for o in points])
    low, high = (frequency < condition.window[0]), (frequency > condition.window[1])
    return np.asarray((low[:-1] & low[1:]) | (high[:-1] & high[1:]))


def deviation(
    before: Sequence[ObservedPoint],
    points: Sequence[ObservedPoint],
    after: Sequence[ObservedPoint],
    condition: RunCondition,
) -> Floats:
    """(n,) how far, at most, the cubics between the points before and after are from the two cubics that lead through
    the points between, in standard deviations.

    Half of a cubic whose value and slope at one end are off by e and d, per unit of the whole, and that is right at the
    other end is off by less than |e| + 2/27 |d|. The slope tells of corners that the cubic happens to cross half way.
    """
    starts, given, ends = (np.array([o.state for o in each]) for each in (before, points, after))
    rates = [np.array([o.along for o in each]) for each in (before, after)]
    length = length_of(ends - starts, (starts + ends) / 2, condition)
    tangents = [
        rate / length_of(rate, state, condition)[:, None] * length[:, None]
        for rate, state in zip(rates, (starts, ends), strict=True)
    ]
    weights = 1 / np.asarray(condition.noise)
    seen, direction = logarithms(given, np.array([o.along for o in points])[:, None])
    direction = weights * direction[:, 0]
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)

    def off(share: Floats) -> tuple[Floats, Floats]:
        """At shares (n, k) of the way: what the points are off (n, k, m), and how that falls with the share"""
        value, rate = _cubic(starts, ends, tangents[0], tangents[1], share)
        value, rate = logarithms(value, rate[..., None, :])
        return weights * to_nearest_turn(seen[:, None] - value), weights * rate[..., 0, :]

    tried = np.broadcast_to(np.linspace(0, 1, _TRIED), (len(given), _TRIED))
    best = np.argmin(np.sum(off(tried)[0] ** 2, axis=-1), axis=1)
    share = tried[np.arange(len(given)), best][:, None]
    for _ in range(_STEPS):
        left, falls = off(share)
        share = np.clip(share + np.sum(left * falls, axis=-1) / np.sum(falls**2, axis=-1), 0, 1)
    left, slope = (each[:, 0] for each in off(share))
    turned = slope - np.sum(slope * direction, axis=-1, keepdims=True) * direction
    return np.asarray(np.linalg.norm(left, axis=-1) + 2 / 27 * np.linalg.norm(turned, axis=-1))


def _cubic(start: Floats, end: Floats, at_start: Floats, at_end: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Hermite's cubics of states (n, m) at shares (n, k) of the way, and their derivatives by the share: (n, k, m)"""
    s = share[..., None]
    chord, first, last = (end - start)[:, None], at_start[:, None], at_end[:, None]
    bend, turn = 3 * chord - 2 * first - last, first + last - 2 * chord
    return start[:, None] + s * (first + s * (bend + s * turn)), first + s * (2 * bend + 3 * s * turn)


def points_between(
    system: NonlinearSystem, excitation: Excitation, pairs: Sequence[tuple[BranchPoint, BranchPoint]]
) -> list[BranchPoint | None]:
    """Of each pair a solved point half way; None where there is none nearer to both than they are to each other."""
    solutions = solve_together(system, excitation, [_half_way(a, b) for a, b in pairs], NEWTON)
    found: list[BranchPoint | None] = []
    for (a, b), solution in zip(pairs, solutions, strict=True):
        point = point_after(a, solution, excitation) if solution.converged else None
        near = point is not None and max(point.step, point.distance(b)) < _BETWEEN * a.distance(b)
        found.append(point if near else None)
    return found


def _half_way(a: BranchPoint, b: BranchPoint) -> Arc:
    """Across the chord, from Hermite's cubic through both"""
    (dx, dw), length = a.move_to(b), a.distance(b)
    x = (a.x + b.x) / 2 + length / 8 * (a.tangent_x - b.tangent_x)
    w = (a.w + b.w) / 2 + length / 8 * (a.tangent_w - b.tangent_w)
    return Arc(x, w, (dx / length, dw / length), a.metric)
