"""Equivalent damping of a nonlinear resonance, three ways; where the system is linear with one mode they agree.

From energy: loss factor eta = W / (2 pi U), damping ratio eta / 2 (Ungar and Kerwin 1962). W is the work of the
excitation a cycle, which is what friction and material dissipate. U, the energy stored, is twice the mean kinetic
energy: with sliders and open contacts the strain energy is not defined without their history, the kinetic energy is,
and at resonance both swing equally far.

From phase: -1 / (w d(phase)/dw) along the response at constant force, at its maximum. There the amplitude is
stationary, hence the equivalent stiffness and damping too, and the slope is that of the linear oscillator of that
amplitude, however strong the nonlinearity; what remains is one mode's formula, and neighbours disturb it.

From the half-power points of a response curve: only where the response is nearly linear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.equation import Equation
from updamp.hbm.problem.system import Excitation
from updamp.hbm.resonance.resonance import ResonanceSolution

Floats = NDArray[np.float64]


def stored_energy(equation: Equation, excitation: Excitation) -> float:
    """Twice the mean kinetic energy over a period, sum_k (k w)^2 |q_k|^2 / 2 [J]; the residual flexibility of the
    linear model has no mass."""
    receptance = equation.receptance
    stuck, harmonics = receptance.system.stuck, receptance.system.harmonics
    loads = -stuck.phi[: stuck.n_relative].T @ equation.departure.value
    total = 0.0
    for k in harmonics.orders:
        load = harmonics.amplitude(loads, k)
        if k == 1:
            load = load + excitation.force * stuck.phi[excitation.row]
        total += (k * receptance.w) ** 2 / 2 * float(np.sum(np.abs(receptance.modal[k] @ load) ** 2))
    return total


def loss_factor(dissipated: float, stored: float) -> float:
    """dissipated: work a cycle [J]; stored: as `stored_energy` gives [J]"""
    return dissipated / (2 * np.pi * stored)


def damping_ratio_from_phase(solution: ResonanceSolution) -> float:
    """Of the equivalent linear oscillator; nan where the phase does not fall with frequency (a turning point between,
    or another mode).

    solution: a maximum of the response; elsewhere the change of amplitude enters the slope
    """
    slope = solution.linearised.y_by_frequency.imag
    return -1 / (solution.w * slope) if slope < 0 else float("nan")


@dataclass(frozen=True)
class HalfPower:
    """damping_ratio: (upper - lower) / (2 peak), nan where it cannot be read, and `reason` why; frequencies [Hz]

    asymmetry: (upper + lower - 2 peak) / (upper - lower), 0 for a light linear oscillator: what nonlinearity bends
    """

    damping_ratio: float
    lower: float
    upper: float
    asymmetry: float
    reason: str


def half_power(curve: ResponseCurve, point: str) -> HalfPower:
    """Half-power bandwidth of the observed first harmonic.

    raises: ValueError for a point that is not on the curve
    """
    size, f = np.abs(curve.receptance(point)), curve.frequency
    peak_frequency, peak = curve.peak(point)
    below = np.flatnonzero(size < peak / np.sqrt(2))
    i = int(np.argmax(size))
    before, after = below[below < i], below[below > i]
    if not len(before) or not len(after):
        return HalfPower(*(4 * (float("nan"),)), "a half-power point lies outside the window")
    a, b = int(before[-1]), int(after[0])
    if (np.sign(np.diff(f[a : b + 1])) != np.sign(f[b] - f[a])).any():
        return HalfPower(*(4 * (float("nan"),)), "the response turns back between the half-power points")
    edges = [_crossing(f[j : j + 2], size[j : j + 2] ** 2, peak**2 / 2) for j in (a, b - 1)]
    lower, upper = min(edges), max(edges)
    width = upper - lower
    asymmetry = (upper + lower - 2 * peak_frequency) / width
    return HalfPower(width / (2 * peak_frequency), lower, upper, asymmetry, "")


def _crossing(f: Floats, squared: Floats, level: float) -> float:
    """1 / |y|^2 is close to a parabola in frequency, and close to straight between neighbours."""
    inverse = 1 / squared
    return float(f[0] + (f[1] - f[0]) * (1 / level - inverse[0]) / (inverse[1] - inverse[0]))
