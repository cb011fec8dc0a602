"""All resonances on a response curve, by phase: coexisting and unstable ones too."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class QuadratureResonance:
    """frequency [Hz]; receptance: size of the first harmonic over the force [m/N]; place: the point of the curve before
    it"""

    frequency: float
    receptance: float
    place: int


def quadrature_resonances(curve: ResponseCurve, point: str) -> list[QuadratureResonance]:
    """Where the branch passes phase quadrature (Peeters, Kerschen and Golinval 2011): the first harmonic lags a quarter
    of a period behind the force, or leads it where the point moves against the excitation, at its largest.

    At an antiresonance the phase is the same and the response at its smallest: there it rises towards the places where
    the phase has changed by 45 degrees, while it falls at a resonance, to 1 / sqrt(2) if it is linear. It is the points
    that are compared, since between few points an antiresonance cannot be told from a narrow resonance. Places where
    the branch was not followed are none.

    raises: ValueError naming the points there are
    """
    receptance = curve.receptance(point)
    real, found = receptance.real, []
    for i in np.flatnonzero((np.sign(real[1:]) * np.sign(real[:-1]) < 0) & ~curve.after_gap[1:]):
        frequency, size = _at_quadrature(curve.frequency[i : i + 2], receptance[i : i + 2])
        nearest = np.abs(receptance[i : i + 2]).max()
        if all(_first_at_45_degrees(side) < nearest for side in (receptance[:i][::-1], receptance[i + 2 :])):
            found.append(QuadratureResonance(frequency, size, int(i)))
    return found


def _at_quadrature(frequency: Floats, receptance: Complex) -> tuple[float, float]:
    """Frequency and size between two points, exact for a linear resonance of small damping: there the tangent of the
    phase's distance from quadrature is linear in frequency, and the points lie on a circle through the origin, whose
    diameter is the size.
    """
    slope, diameter = receptance.real / receptance.imag, np.abs(receptance) ** 2 / np.abs(receptance.imag)
    share = slope[0] / (slope[0] - slope[1])
    at, size = (float(pair[0] + share * (pair[1] - pair[0])) for pair in (frequency, diameter))
    return at, size


def _first_at_45_degrees(side: Complex) -> float:
    """Size of the response where its phase is 45 degrees off quadrature, or where the branch ends before; 0 without any
    points."""
    off = np.flatnonzero(np.abs(side.real) > np.abs(side.imag))
    return float(abs(side[off[0] if len(off) else -1])) if len(side) else 0.0
