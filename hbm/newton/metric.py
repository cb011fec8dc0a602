"""How far apart two points of a branch are: the metric of continuation.

It is relative: displacements are measured against the vibration at a point, and frequency against a given scale, so
that steps are even in the logarithm of the amplitude and in the phase, off resonance and on it.

The mean position hardly counts. Where all contacts slip, only the bending of the blades holds it: it drifts by many
times the vibration, and turns back sharply wherever a contact sticks again, while amplitude and frequency go on
evenly. Measured with it, a branch is all kinks. Where it becomes thousands of times the vibration, as where all
contacts slip in a direction and nothing but wires holds the damper, it is measured against itself: the vibration
still counts, and the drift is passed in its logarithm.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]
Move = tuple[Floats, float]

# Weight of the mean position: not zero, so that a move of it alone has a length.
MEAN = 1e-3
# A vibration below this share of the mean position is none.
_LEAST = 1e-9


@dataclass(frozen=True, eq=False)
class Metric:
    """weights: (n_coefficients,) of the displacements' coefficients [1/m]; scale_w: one unit of arc [rad/s]"""

    weights: Floats
    scale_w: float

    @staticmethod
    def at(x: Floats, harmonics: Harmonics, scale_w: float, least: float = 0.0) -> "Metric":
        """x: (n_relative, n_coefficients) [m]; least: the least vibration that displacements are measured against, so
        that round-off is no way (`Equation.least`) [m]"""
        weights = np.ones(harmonics.n_coefficients)
        mean = 0.0
        if 0 in harmonics.orders:
            weights[harmonics.slices[0]] = 0.0
            mean = float(np.linalg.norm(x[:, harmonics.slices[0]]))
        vibration = max(float(np.linalg.norm(weights * x)), _LEAST * mean, least, np.finfo(float).tiny)
        weights /= vibration
        if 0 in harmonics.orders:
            weights[harmonics.slices[0]] = MEAN / (vibration + MEAN * mean)
        return Metric(weights, scale_w)

    def product(self, a: Move, b: Move) -> float:
        """Inner product of two moves (dx, dw)."""
        return float(np.vdot(self.weights * a[0], self.weights * b[0]) + a[1] * b[1] / self.scale_w**2)

    def length(self, move: Move) -> float:
        return float(np.sqrt(self.product(move, move)))


def to_lines(places: Floats) -> tuple[Floats, Floats]:
    """From the origin to each of the straight lines between neighbouring places (n, dimensions): distance (n - 1,), and
    where on the line the nearest place is, from 0 to 1."""
    start, along = places[:-1], np.diff(places, axis=0)
    length = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    share = np.clip(-np.einsum("ij,ij->i", start, along) / length, 0.0, 1.0)
    return np.linalg.norm(start + share[:, None] * along, axis=1), share
