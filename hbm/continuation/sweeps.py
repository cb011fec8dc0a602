"""What a slow sweep would see of a branch: the parts it follows and the frequencies where it jumps.

By the folds of the branch alone. Where its motions lose their stability otherwise, as to a beating one, a sweep leaves
it before: `hbm/stability/branch_stability.py` tells which points are unstable.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.completeness import CompletenessLimits, relative_change
from updamp.hbm.continuation.response_curve import ResponseCurve

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Sweep:
    """visited: (n,) places on the branch in the order of the sweep; jumps: (n_jumps,) frequencies [Hz], in that order;
    jump_after: (n_jumps,) place in `visited` after which each jump happens"""

    visited: Integers
    jumps: Floats
    jump_after: Integers


def turning_points(frequency: Floats) -> Integers:
    """Places on the branch where the frequency turns round, the ends not among them."""
    direction = np.sign(np.diff(frequency))
    return 1 + np.flatnonzero(direction[1:] * direction[:-1] < 0)


def sweep(frequency: Floats, upwards: bool) -> Sweep:
    """Follow the branch with rising (or falling) frequency; where it turns back, jump to the next part further along
    that exists at the same frequency. Parts that run against the sweep lie between two turning points: a sweep does
    not see them.

    frequency: (n,) [Hz] in the order of the branch, which starts and ends at opposite sides of the window
    raises: ValueError for fewer than two points
    """
    if len(frequency) < 2:
        raise ValueError(f"a sweep needs at least two points of the branch; there are {len(frequency)}")
    order = np.arange(len(frequency))
    if (frequency[-1] > frequency[0]) != upwards:
        order = order[::-1]
    along = frequency[order] if upwards else -frequency[order]
    visited: list[int] = []
    jumps: list[float] = []
    jump_after: list[int] = []
    start = 0
    while True:
        falls = np.flatnonzero(np.diff(along[start:]) < 0)
        end = start + int(falls[0]) if len(falls) else len(along) - 1
        visited.extend(order[start : end + 1])
        after_jump = _after_jump(along, end)
        if after_jump is None:
            break
        jumps.append(frequency[order[end]])
        jump_after.append(len(visited) - 1)
        start = after_jump
    return Sweep(np.array(visited), np.array(jumps), np.array(jump_after, dtype=np.int64))


def swept(curve: ResponseCurve, upwards: bool, limits: CompletenessLimits | None = None) -> Sweep:
    """As `sweep`, with those jumps only that show: across which the response changes by more than what counts as
    continuous. Where contacts change their states a branch turns back by hundredths of a hertz dozens of times; which
    of these folds are resolved depends on round-off.
    """
    limits = limits or CompletenessLimits()
    seen, response = sweep(curve.frequency, upwards), curve.amplitudes()
    show = [_change(curve.frequency, response, *seen.visited[[at, at + 1]]) > limits.change for at in seen.jump_after]
    return replace(seen, jumps=seen.jumps[show], jump_after=seen.jump_after[show])


def _change(frequency: Floats, response: Complex, end: int, landing: int) -> float:
    """Of the response (n, n_points) across a jump, at the frequency at which it happens: the branch passes that
    between the landing and the point before it, or has passed it where it has turned round since."""
    before = landing - int(np.sign(landing - end))
    rise, whole = frequency[end] - frequency[before], frequency[landing] - frequency[before]
    share = rise / whole if 0 < rise * whole < whole**2 else 1.0
    return relative_change(response[end], response[before] + share * (response[landing] - response[before]))


def _after_jump(along: Floats, end: int) -> int | None:
    """First later place beyond the fold's frequency, on a part that runs with the sweep."""
    later = np.arange(end + 1, len(along))
    beyond = later[(along[later] > along[end]) & (np.diff(along[end:]) > 0)]
    return int(beyond[0]) if len(beyond) else None
