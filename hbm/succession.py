"""Whether a branch runs from one point to another that Newton's method has found ahead of it."""

import numpy as np

from updamp.hbm.branch import BranchPoint
from updamp.hbm.metric import Move

# A change of orientation further apart than this is no bifurcation that was passed, but another branch.
_BIFURCATION = 2e-3
# Cosines between tangent and move: of an ordinary step, and of one through a bifurcation.
_AHEAD, _STRAIGHT = 0.3, 0.9


def goes_on(last: BranchPoint, point: BranchPoint) -> bool:
    """Whether the branch runs from one to the other: ahead, and with its orientation kept (hbm/corner.py).

    The response of a symmetric structure is symmetric, and goes straight on through bifurcations to asymmetric ones;
    the sign changes there. Where it is dear to know, it is not asked for.
    """
    move = last.to(point)
    cosine = point.metric.product(point.tangent, move) / point.metric.length(move)
    before, after = last.orientation, point.orientation
    kept = before is None or after is None or before == after
    ahead = cosine > _AHEAD if kept else point.step < _BIFURCATION and cosine > _STRAIGHT
    return ahead and (point.step < _BIFURCATION or _led_there(last, point))


def _led_there(last: BranchPoint, point: BranchPoint) -> bool:
    """Whether the tangents at both points account for the move: else it ended on another branch.

    Between them the branch turns once at most, smoothly or in a corner, so that the move differs from the mean of the
    tangents by half their difference at most. Asked of mean position, vibration and frequency each.
    """
    length, metric = point.step, last.metric
    unit = metric.length(point.tangent)
    (move_x, move_w), (x0, w0) = last.to(point), last.tangent
    x1, w1 = point.tangent_x / unit, point.tangent_w / unit
    off = (move_x / length - (x0 + x1) / 2, move_w / length - (w0 + w1) / 2)
    turn = (x1 - x0, w1 - w0)
    sizes = [_sizes(move, last) for move in (off, turn, (x0, w0), (x1, w1))]
    floors = (0.02 / metric.weights.max(), 0.02, 0.02)  # of a mean position that hardly moves: against the vibration
    return all(o <= 0.8 * t + 0.25 * max(a, b) + floor for o, t, a, b, floor in zip(*sizes, floors, strict=True))


def _sizes(move: Move, last: BranchPoint) -> tuple[float, float, float]:
    """Of the mean position [m], of the vibration and of the frequency, as the metric at the last point has them."""
    (dx, dw), metric = move, last.metric
    harmonics = last.solution.equation.receptance.system.harmonics
    vibration = metric.weights * dx
    mean = 0.0
    if 0 in harmonics.orders:
        mean = float(np.linalg.norm(dx[:, harmonics.slices[0]]))
        vibration[:, harmonics.slices[0]] = 0.0
    return mean, float(np.linalg.norm(vibration)), abs(dw) / metric.scale_w
