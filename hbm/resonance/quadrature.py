"""All resonances on a response curve, by phase: coexisting and unstable ones too."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import KroghInterpolator

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
        near = _one_by_one(receptance, curve.after_gap, int(i))
        frequency, size = _at_quadrature(curve.frequency[near], receptance[near])
        nearest = np.abs(receptance[i : i + 2]).max()
        if all(_first_at_45_degrees(side) < nearest for side in (receptance[:i][::-1], receptance[i + 2 :])):
            found.append(QuadratureResonance(frequency, size, int(i)))
    return found


def _one_by_one(receptance: Complex, after_gap: NDArray[np.bool_], i: int) -> NDArray[np.intp]:
    """Points i and i + 1 on both sides of quadrature, and their other neighbours where the phase goes on the same way,
    within 45 degrees of quadrature, without a gap."""
    first, last = max(i - 1, 0), min(i + 3, len(receptance))
    off = dict(zip(range(first, last), _off(receptance[first:last]).tolist(), strict=True))
    way = np.sign(off[i + 1] - off[i])
    near = [i, i + 1]
    if i - 1 in off and not after_gap[i] and abs(off[i - 1]) < 1 and way * (off[i] - off[i - 1]) > 0:
        near.insert(0, i - 1)
    if i + 2 in off and not after_gap[i + 2] and abs(off[i + 2]) < 1 and way * (off[i + 2] - off[i + 1]) > 0:
        near.append(i + 2)
    return np.array(near)


def _at_quadrature(frequency: Floats, receptance: Complex) -> tuple[float, float]:
    """Frequency and size between the points, by polynomials through all of them, in the tangent of the phase's distance
    from quadrature. Of a linear resonance of small damping that tangent is linear in frequency, and all points lie on
    one circle through the origin, whose diameter is the size: exact with two points. Friction's loss changes along the
    curve, and the diameter with it.
    """
    diameter = np.abs(receptance) ** 2 / np.abs(receptance.imag)
    through = KroghInterpolator(_off(receptance), np.stack([frequency, diameter], axis=1))
    at, size = through(0.0)
    return float(at), float(size)


def _off(receptance: Complex) -> Floats:
    """Tangent of the phase's distance from quadrature"""
    return receptance.real / np.where(receptance.imag == 0, np.finfo(float).tiny, receptance.imag)


def _first_at_45_degrees(side: Complex) -> float:
    """Size of the response where its phase is 45 degrees off quadrature, or where the branch ends before; 0 without any
    points."""
    off = np.flatnonzero(np.abs(side.real) > np.abs(side.imag))
    return float(abs(side[off[0] if len(off) else -1])) if len(side) else 0.0
