"""Modal constant and pole of a resonance, from the straight line that 1/H is about it.

1/H = (w_r^2 (1 + i eta) - w^2) / A, whose slope in w^2 gives A whatever the damping is (D. J. Ewins, Modal Testing,
2000, ch. 4).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class StraightLine:
    """points: fewest that show a resonance: frequency, damping and a complex height are four numbers
    height: points from this share of the peak on are used; scatter: of them about the straight line, relative, and
    of its slopes on both sides of the resonance, up to which it tells
    """

    points: int = 5
    height: float = 0.3
    scatter: float = 0.3


@dataclass(frozen=True)
class ModalFit:
    """constant: A [1/kg], with its phase; pole: w_r^2 (1 + i eta) [rad^2/s^2], below the real axis where the phase runs
    the other way"""

    constant: complex
    pole: complex


def modal_fit(frequency: Floats, receptance: Complex) -> ModalFit | None:
    """frequency: (n,) [Hz]; receptance: (n,) [m/N]

    returns: None where too few points lie on a line, or it is not as steep on both sides of the resonance: one that
        bends over shows a straight line on one side, of another slope
    """
    size = np.abs(receptance)
    if not np.all(size > 0):
        return None
    near = size >= StraightLine.height * size.max()
    if near.sum() < StraightLine.points:
        return None
    squared, H = (2 * np.pi * frequency[near]) ** 2, receptance[near]
    middle, spread = squared.mean(), np.ptp(squared)
    columns = np.stack([np.ones_like(squared), (squared - middle) / spread], axis=1) * H[:, None]
    line = np.linalg.lstsq(columns, np.ones(len(H), complex), rcond=None)[0]
    left = np.abs(columns @ line - 1)
    if np.sqrt(np.mean(left**2)) > StraightLine.scatter or line[1] == 0:
        return None
    stiffness = np.real(np.conj(line[1]) / np.abs(line[1]) / H)  # negative on one side of the resonance
    sides = [_slope(squared[one], stiffness[one], spread) for one in (stiffness < 0, stiffness >= 0)]
    if not all(abs(slope / np.abs(line[1]) - 1) <= StraightLine.scatter for slope in sides):
        return None
    constant = complex(-spread / line[1])
    return ModalFit(constant, complex(constant * line[0] + middle))


def _slope(squared: Floats, stiffness: Floats, spread: float) -> float:
    """Of a straight line; nan of less than two points."""
    return float(np.polyfit((squared - squared.mean()) / spread, stiffness, 1)[0]) if len(squared) > 1 else np.nan
