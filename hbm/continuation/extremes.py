"""Solved points at what is read off a curve: the top of its peak, and the folds at which slow sweeps jump.

Between points a step of arc apart an extreme depends on where they happen to lie: the height of a sharp peak by 0.1 to
0.2 % (IP at 9.6 and 17 N of the reference rig, benchmarks/reproducibility.py).
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.curve_records import CurveRequest, with_point
from updamp.hbm.continuation.response_curve import Extreme, ResponseCurve
from updamp.hbm.continuation.sweeps import sweep
from updamp.hbm.newton.metric import Metric, Move
from updamp.hbm.newton.newton import Arc, solve
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]


def with_extremes_solved(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> ResponseCurve:
    """The curve with further points, at the top of the largest first harmonic at each point where the peak is told and
    at the last frequency before each jump of a slow sweep, whether it shows (`sweeps.swept`) or not: how far the
    response jumps is known at the fold alone."""
    for upwards in (True, False):
        curve = _with_hidden_folds(system, request, curve, upwards)
        for jump in range(len(sweep(curve.frequency, upwards).jumps)):
            curve = _with_solved(system, request, curve, partial(_fold, request, upwards, jump))
    # last, as the height is read from a spline through the points about it, those of a fold among them
    still = request.assembly.limits.still
    for point in (point for point in request.peaks_at if not curve.stands_still(point, still)):
        curve = _with_solved(system, request, curve, partial(_highest, request, point))
    return curve


def _with_hidden_folds(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, upwards: bool
) -> ResponseCurve:
    """With points where a spline through those that a slow sweep visits turns back between two of them: a step may have
    gone across a fold at which the sweep jumps. Each pair of points is asked once, and no more are put in than there
    are."""
    asked: set[tuple[float, float]] = set()
    for _ in range(len(curve)):
        if (hidden := _first_hidden(request, curve, upwards, asked)) is None:
            break
        curve = _with_point_at(system, request, curve, hidden)
    return curve


def _first_hidden(
    request: CurveRequest, curve: ResponseCurve, upwards: bool, asked: set[tuple[float, float]]
) -> Extreme | None:
    """Of pairs that have not been asked; these are added to those that have."""
    visited = sweep(curve.frequency, upwards).visited
    along = curve.frequency if upwards else -curve.frequency
    for one, next_one in pairwise(visited.tolist()):
        first, pair = min(one, next_one), (float(curve.frequency[one]), float(curve.frequency[next_one]))
        if abs(next_one - one) != 1 or pair in asked:
            continue
        asked.add(pair)
        values = along if one < next_one else -along
        if (found := curve.hidden_extreme(values, int(first), request.peaks_at[0])) is not None:
            return found
    return None


def _with_solved(
    system: NonlinearSystem,
    request: CurveRequest,
    curve: ResponseCurve,
    expected: Callable[[ResponseCurve], Extreme | None],
) -> ResponseCurve:
    """With points added where the extreme is expected, until one is there."""
    for _ in range(request.assembly.points_at_extreme):
        before, curve = curve, _with_point_at(system, request, curve, expected(curve))
        if curve is before:
            break
    return curve


def _highest(request: CurveRequest, point: str, curve: ResponseCurve) -> Extreme | None:
    """The expected top that is highest; of several maxima of about the same height, not the one that happens to have
    the largest point: over a step of arc the amplitude changes by a share of at most that size."""
    size = np.abs(curve.receptance(point))
    inner = 1 + np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:]))
    high = inner[size[inner] * (1 + request.options.largest_step) >= size.max()]
    tops = [top for place in high if (top := curve.extreme(size, int(place), point)) is not None]
    return max(tops, key=lambda top: top.value, default=None)


def _fold(request: CurveRequest, upwards: bool, jump: int, curve: ResponseCurve) -> Extreme | None:
    """The last frequency before a jump, by its number; None where there are fewer: the fold before it reaches beyond
    this one."""
    seen = sweep(curve.frequency, upwards)
    if jump >= len(seen.jumps):
        return None
    place = int(seen.visited[seen.jump_after[jump]])
    return curve.extreme(curve.frequency if upwards else -curve.frequency, place, request.peaks_at[0])


def _with_point_at(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, extreme: Extreme | None
) -> ResponseCurve:
    """With one more solved point, where the points about an extreme say that it is; the same curve where one is there,
    or none is found."""
    if extreme is None:
        return curve
    there = np.abs(extreme.length - extreme.at).min() < request.assembly.there * extreme.length[-1]
    if there or curve.after_gap[extreme.near][1:].any():
        return curve
    point = _between(system, request, curve, extreme)
    return curve if point is None else with_point(system, request, curve, point, extreme.near.start + extreme.after)


def _between(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, extreme: Extreme
) -> BranchPoint | None:
    """The solution about the extreme, on the plane across the chord between the points on both sides of it: so it
    lies between them, beside kinks too, where the spline through the points goes astray. It is sought from the chord.
    None where there is none within the chord's length of it: that is another branch."""
    near, length, at = extreme.near, extreme.length, extreme.at
    places = np.column_stack([curve.displacement[near].reshape(len(length), -1), 2 * np.pi * curve.frequency[near]])
    after, scale_w = extreme.after, request.options.scale_w(request.window)

    def move(place: Floats) -> Move:
        return np.reshape(place[:-1], curve.displacement.shape[1:]), float(place[-1])

    a, b = places[after - 1 : after + 1]
    share = (at - length[after - 1]) / (length[after] - length[after - 1])
    on_chord = move(a + share * (b - a))
    metric = Metric.at(on_chord[0], system.harmonics, scale_w)
    chord = metric.length(move(b - a))
    dx, dw = move((b - a) / chord)
    solution = solve(system, request.excitation, *on_chord, request.options.newton, Arc(*on_chord, (dx, dw), metric))
    if not solution.converged or metric.length((solution.x - on_chord[0], solution.w - on_chord[1])) > chord:
        return None
    return point_at(solution, request.excitation, scale_w, (dx, dw), 0.0)
