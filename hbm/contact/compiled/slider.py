"""The march of a slider from node to node, and its force's Fourier coefficients with their tangent.

The path of the slider, w(t), is a constant where it sticks, the motion less the limit where it slips, the motion itself
where the contact is open. What it takes from the force of the spring alone are the integrals of its path against the
harmonics, piece by piece. The path is continuous, so that no derivative is needed of where a piece ends. A slider
always stands where one node put it, its source, and these are few: the tangent of what sticks is a sum over sources.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.columns import Columns, Rows, add_numbers, empty, multiply, new_columns
from updamp.hbm.contact.compiled.cubic import (
    basis,
    basis_halves,
    halves,
    powers,
    rise_through,
    slope,
)
from updamp.hbm.contact.compiled.event_grid import Grid, Path, compression_of, motion_of
from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.shared import WHOLE_END, WHOLE_START
from updamp.hbm.contact.compiled.tables import size_of_change

Floats = NDArray[np.float64]

# What a slider does: where the contact is open it goes along.
STANDS, OPEN, UP, DOWN = 0, 1, 2, 3
# What the limit is multiplied by where it slips up or down.
SIGN = (0.0, 0.0, 1.0, -1.0)


class Slider(NamedTuple):
    """position: of the slider at each node [m]; source: the node that put it there, -1 where it stands as at first
    side: of each source, 1 where it pushed up to u less the limit, -1 down to u plus the limit, 0 where there is none
    does: what it does before it comes to the next node; slips: share of the segment from which on, the end where it
        stands until then
    whole: (n_time,) what it does in each segment from start to end, STANDS where that is several things
    """

    position: Floats
    source: NDArray[np.int64]
    side: Floats
    does: NDArray[np.int64]
    slips: Floats
    whole: NDArray[np.int64]


class Scratch(NamedTuple):
    """Of one direction. force: (n_coefficients,) [m], over kt; by_u, by_p: its derivatives (n_coefficients,
    n_coefficients); integrals: (n_time + 1,) of the path against each hat [m]
    sources: (n_nodes, n_coefficients) what stands where each node put it adds to the coefficients; used: (n_nodes,)
        whether anything does
    """

    force: Floats
    by_u: NDArray[Any]
    by_p: NDArray[Any]
    integrals: Floats
    sources: NDArray[Any]
    used: NDArray[np.bool_]
    u: Columns
    p: Columns


@inner
def new_slider(n_nodes: int, n: int) -> Slider:
    source, does, whole = np.empty(n_nodes, np.int64), np.empty(n_nodes, np.int64), np.empty(n, np.int64)
    return Slider(np.empty(n_nodes), source, np.empty(n_nodes), does, np.empty(n_nodes), whole)


@inner
def new_scratch(n_nodes: int, weights: Any) -> Scratch:
    """weights: `Tables.weights`; what belongs to tangents is of their kind of numbers"""
    c, kind = weights.shape[1], weights.dtype
    square = np.empty((c, c), kind)
    integrals, sources, used = np.empty(len(weights)), np.empty((n_nodes, c), kind), np.empty(n_nodes, np.bool_)
    columns = new_columns(weights), new_columns(weights)
    return Scratch(np.empty(c), square, square.copy(), integrals, sources, used, columns[0], columns[1])


@inner
def march(grid: Grid, first: float, cycles: int, slider: Slider) -> None:
    """first: where the slider rests [m]"""
    n, stands, source = grid.number[0], first, -1
    u, limit, free = grid.u, grid.limit, grid.free
    position, sources, side = slider.position, slider.source, slider.side
    for cycle in range(cycles):
        # the node at the end is the first one of the next period
        for k in range(n + 1 if cycle == cycles - 1 else n):
            if free[k]:
                stands, source, side[k] = u[k], k, 0.0
            elif stands < u[k] - limit[k]:
                stands, source, side[k] = u[k] - limit[k], k, 1.0
            elif stands > u[k] + limit[k]:
                stands, source, side[k] = u[k] + limit[k], k, -1.0
            position[k], sources[k] = stands, source


@inner
def tell_apart(grid: Grid, path: Path, ratio: float, slider: Slider) -> None:
    """What the slider does from each node to the next, and from where on: where it stands is known (`march`)."""
    u, du, p, dp = path.u, path.du, path.p, path.dp
    segment, share, ends, closed, position = grid.segment, grid.share, grid.end, grid.closed, slider.position
    does, slips, whole = slider.does, slider.slips, slider.whole
    whole[:] = STANDS
    for k in range(grid.number[0]):
        j, end = segment[k], ends[k]
        does[k], slips[k] = STANDS, end
        if not closed[k]:
            does[k], slips[k] = OPEN, share[k]
        elif position[k + 1] != position[k]:
            does[k], sign = (UP, 1.0) if position[k + 1] > position[k] else (DOWN, -1.0)
            pushed = powers(
                u[j] - sign * ratio * p[j], u[j + 1] - sign * ratio * p[j + 1],
                du[j] - sign * ratio * dp[j], du[j + 1] - sign * ratio * dp[j + 1],
            )  # fmt: skip
            slips[k] = rise_through(pushed, position[k], sign, share[k], end)
        if slips[k] == 0 and end == 1:
            whole[j] = does[k]


@inner
def add_force(grid: Grid, path: Path, ratio: float, slider: Slider, weights: Floats, out: Scratch) -> None:
    """Takes the path of the slider from out.force, that of a spring alone, over kt."""
    u, du, p, dp = path.u, path.du, path.p, path.dp
    segment, share, position, integrals = grid.segment, grid.share, slider.position, out.integrals
    integrals[:] = 0.0
    for k in range(grid.number[0]):
        j = segment[k]
        begin, slips, end = share[k], slider.slips[k], grid.end[k]
        if begin == 0 and slips == 1:
            integrals[j] += position[k] / 2
            integrals[j + 1] += position[k] / 2
            continue
        if slips > begin:
            start, after = halves((position[k], 0.0, 0.0, 0.0), begin, slips)
            integrals[j] += start
            integrals[j + 1] += after
        if end > slips:
            factor = ratio * SIGN[slider.does[k]]
            v0, v1 = u[j] - factor * p[j], u[j + 1] - factor * p[j + 1]
            d0, d1 = du[j] - factor * dp[j], du[j + 1] - factor * dp[j + 1]
            if slips == 0 and end == 1:
                start = WHOLE_START[0] * v0 + WHOLE_START[1] * v1 + WHOLE_START[2] * d0 + WHOLE_START[3] * d1
                after = WHOLE_END[0] * v0 + WHOLE_END[1] * v1 + WHOLE_END[2] * d0 + WHOLE_END[3] * d1
            else:
                start, after = halves(powers(v0, v1, d0, d1), slips, end)
            integrals[j] += start
            integrals[j + 1] += after
    for t in range(len(weights)):
        for a in range(len(out.force)):
            out.force[a] -= weights[t, a] * integrals[t]


@inner
def add_tangent(
    grid: Grid,
    path: Path,
    u: Rows,
    p: Rows,
    ratio: float,
    slider: Slider,
    weights: Any,
    last_period: Any,
    out: Scratch,
) -> None:
    """Adds to out.by_u and out.by_p the derivatives of what `add_force` has added.

    last_period: factor of what moved the slider in the period before (1 where the motion's change is periodic)
    """
    gather_tangent(grid, path, ratio, slider, weights, last_period, out)
    multiply(out.u, u, out.by_u)
    multiply(out.p, p, out.by_p)


@inner
def gather_tangent(
    grid: Grid, path: Path, ratio: float, slider: Slider, weights: Any, last_period: Any, out: Scratch
) -> None:
    """Writes out.u and out.p: what motion and limit add to the coefficients, to be multiplied by their derivatives."""
    empty(out.u)
    empty(out.p)
    used = out.used
    used[: grid.number[0] + 1] = False
    _add_whole(slider, ratio, weights, out)
    segment, share, sources, source_of = grid.segment, grid.share, out.sources, slider.source
    for k in range(grid.number[0]):
        j, begin, slips, end, source = segment[k], share[k], slider.slips[k], grid.end[k], source_of[k]
        if slips > begin and source >= 0:
            if not used[source]:
                used[source], sources[source] = True, 0.0
            size = size_of_change(source > k, last_period)
            start, after = halves((1.0, 0.0, 0.0, 0.0), begin, slips)
            for a in range(weights.shape[1]):
                sources[source, a] -= size * (start * weights[j, a] + after * weights[j + 1, a])
        if end > slips and slider.whole[j] == STANDS:
            _add_piece(basis_halves(slips, end), j, ratio * SIGN[slider.does[k]], weights, out)
    for k in range(grid.number[0] + 1):
        if used[k]:
            _add_source(grid, path, ratio, slider.side[k], k, out)


@inner
def _add_whole(slider: Slider, ratio: float, weights: Any, out: Scratch) -> None:
    """Segments in which the slider only slips, or the contact is open: where neighbours do the same, the hat between
    them is one."""
    n = len(slider.whole)
    for j in range(n):
        does = slider.whole[j]
        if does == STANDS:
            continue
        factor = ratio * SIGN[does]
        if slider.whole[j - 1] == does:  # before the first comes the last
            for a in range(len(out.force)):
                out.u.hats[j, a] -= weights[j, a]
                out.p.hats[j, a] += factor * weights[j, a]
        else:
            _add_half(WHOLE_START, j, factor, weights[j], out)
        if slider.whole[(j + 1) % n] != does:
            _add_half(WHOLE_END, j, factor, weights[j + 1], out)


@inner
def _add_half(by: Any, j: int, factor: float, weight: Any, out: Scratch) -> None:
    """by: derivatives of an integral of u in segment j by its four numbers; less factor times that of p"""
    add_numbers(by, j, -1.0, weight, out.u)
    if factor != 0:
        add_numbers(by, j, factor, weight, out.p)


@inner
def _add_piece(by: Any, j: int, factor: float, weights: Any, out: Scratch) -> None:
    _add_half(by[0], j, factor, weights[j], out)
    _add_half(by[1], j, factor, weights[j + 1], out)


@inner
def _add_source(grid: Grid, path: Path, ratio: float, side: float, k: int, out: Scratch) -> None:
    """The derivatives of where node k puts the slider."""
    j, t, weight = grid.segment[k], grid.share[k], out.sources[k]
    by = basis(t)
    add_numbers(by, j, 1.0, weight, out.u)
    if side != 0:
        add_numbers(by, j, -side * ratio, weight, out.p)
    elif grid.crossing[k]:  # it is put where the motion is then, and that moves with the instant
        rate = slope(motion_of(path, j), t) / slope(compression_of(path.p, path.dp, j), t)
        add_numbers(by, j, -rate, weight, out.p)
