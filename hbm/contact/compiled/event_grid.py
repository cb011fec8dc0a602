"""Where a motion is looked at: the samples, and between them what `event_march.py` names, for numba.

Between two neighbouring nodes the contact is closed throughout or open throughout, and neither position to which the
slider can be pushed has a turn that matters: marching from node to node is marching exactly.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.cubic import less, positive, powers, rise_through, slope, top, value
from updamp.hbm.contact.compiled.keeping import inner

Floats = NDArray[np.float64]

# Of one segment: its sample, two openings or closings, and in each of two closed parts a turn of either position.
MOST_NODES = 7


class Openings(NamedTuple):
    """first, second: (n_time,) shares of each segment after which the contact opens or closes, -1 for none"""

    first: Floats
    second: Floats


class Path(NamedTuple):
    """Motion at the samples, all (n_time + 1,): u of the spring's end [m] and its slope du a sample, p the compression
    that sets the limit [m] and its slope (`event_march._friction`)."""

    u: Floats
    du: Floats
    p: Floats
    dp: Floats


class Grid(NamedTuple):
    """Nodes in the order of time, the last one at the end of the period.

    number: (1,) of nodes but for the last; segment, share: where a node is; end: share at which the next one is
    crossing: whether the contact opens or closes there
    free: whether nothing presses there; closed: whether it is closed from here to the next node
    u, limit: of the trial force, over kt [m]
    sample: (n_time + 1,) nodes of the samples
    """

    number: NDArray[np.int64]
    segment: NDArray[np.int64]
    share: Floats
    end: Floats
    crossing: NDArray[np.bool_]
    free: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    u: Floats
    limit: Floats
    sample: NDArray[np.int64]


@inner
def new_openings(n: int) -> Openings:
    return Openings(np.empty(n), np.empty(n))


@inner
def new_path(n: int) -> Path:
    return Path(np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty(n + 1))


@inner
def new_grid(n: int) -> Grid:
    most = MOST_NODES * n + 1
    segment, sample = np.empty(most, dtype=np.int64), np.empty(n + 1, dtype=np.int64)
    state = np.empty((3, most), dtype=np.bool_)
    number = np.zeros(1, dtype=np.int64), segment
    return Grid(
        *number, np.empty(most), np.empty(most), state[0], state[1], state[2], np.empty(most), np.empty(most), sample
    )


@inner
def motion_of(path: Path, j: int) -> Any:
    return powers(path.u[j], path.u[j + 1], path.du[j], path.du[j + 1])


@inner
def compression_of(p: Floats, dp: Floats, j: int) -> Any:
    return powers(p[j], p[j + 1], dp[j], dp[j + 1])


@inner
def find_openings(p: Floats, dp: Floats, openings: Openings) -> None:
    """p, dp: (n_time + 1,) compression and its slope"""
    for j in range(len(p) - 1):
        openings.first[j] = openings.second[j] = -1.0
        sign = 1.0 if p[j + 1] > 0 else -1.0
        if (p[j] > 0) != (p[j + 1] > 0):
            openings.first[j] = rise_through(compression_of(p, dp, j), 0.0, sign, 0.0, 1.0)
        elif sign * dp[j] < 0 and sign * dp[j + 1] > 0:  # it may open and close again, or close and open
            c = compression_of(p, dp, j)
            turn = top(less((0.0, 0.0, 0.0, 0.0), sign, c), 0.0, 1.0)
            if sign * value(c, turn) < 0:
                openings.first[j] = rise_through(c, 0.0, -sign, 0.0, turn)
                openings.second[j] = rise_through(c, 0.0, sign, turn, 1.0)


@inner
def parts(begins: bool, first: float, second: float) -> Any:
    """Ends of two parts of a segment between which a state holds that changes at first and second; empty ones end where
    they begin. begins: whether it holds at the start."""
    until = second if second >= 0 else 1.0
    if begins:
        return 0.0, (first if first >= 0 else 1.0), until, 1.0
    return (first, until, 1.0, 1.0) if first >= 0 else (1.0, 1.0, 1.0, 1.0)


@inner
def build_grid(path: Path, ratio: float, openings: Openings, grid: Grid) -> None:
    """ratio: what p is multiplied by for the slip limit over kt"""
    u, du, p, dp, first = path.u, path.du, path.p, path.dp, openings.first
    n, k = len(u) - 1, 0
    for j in range(n):
        grid.sample[j] = k
        _set(grid, k, j, 0.0, False, p[j] > 0, u[j], ratio * positive(p[j]))
        k += 1
        # turns of the two positions that the slider can be pushed to
        up = du[j] > ratio * dp[j] and du[j + 1] < ratio * dp[j + 1]
        down = -du[j] > ratio * dp[j] and -du[j + 1] < ratio * dp[j + 1]
        if first[j] >= 0 or (p[j] > 0 and (up or down)):
            k = _add_between(path, ratio, openings, j, grid, k)
    grid.sample[n] = grid.number[0] = k
    _set(grid, k, n - 1, 1.0, False, p[n] > 0, u[n], ratio * positive(p[n]))
    for i in range(k):
        grid.end[i] = grid.share[i + 1] if grid.segment[i + 1] == grid.segment[i] else 1.0


@inner
def _add_between(path: Path, ratio: float, openings: Openings, j: int, grid: Grid, k: int) -> int:
    """Adds what is between the samples of segment j; returns the number of the next node."""
    u, p = motion_of(path, j), compression_of(path.p, path.dp, j)
    closed, begin = path.p[j] > 0, 0.0
    for end in (openings.first[j], openings.second[j], 1.0):
        if end < 0:
            continue
        if closed:
            # highest point of where the slider can be pushed up to, and lowest of where it can be pushed down to
            at = (_turn(u, p, ratio, 1.0, begin, end), _turn(u, p, ratio, -1.0, begin, end))
            for t in (min(at[0], at[1]), max(at[0], at[1])):
                if t >= 0:
                    _set(grid, k, j, t, False, True, value(u, t), ratio * positive(value(p, t)))
                    k += 1
        if end < 1:
            closed, begin = not closed, end
            _set(grid, k, j, end, True, closed, value(u, end), 0.0)
            k += 1
    return k


@inner
def _turn(u: Any, p: Any, ratio: float, sign: float, a: float, b: float) -> float:
    """-1 where there is none."""
    pushed = less((sign * u[0], sign * u[1], sign * u[2], sign * u[3]), ratio, p)
    return top(pushed, a, b) if slope(pushed, a) > 0 and slope(pushed, b) < 0 else -1.0


@inner
def _set(grid: Grid, k: int, j: int, t: float, crossing: bool, closed: bool, u: float, limit: float) -> None:
    grid.segment[k], grid.share[k], grid.crossing[k], grid.closed[k] = j, t, crossing, closed
    grid.u[k], grid.limit[k], grid.free[k] = u, limit, crossing or not closed
