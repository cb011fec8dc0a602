"""Equivalent damping of a nonlinear resonance, two ways; where the system is linear with one mode they agree.

From energy: loss factor eta = W / (2 pi U), damping ratio eta / 2 (Ungar and Kerwin 1962). W is the work of the
excitation a cycle, which is what friction and material dissipate. U, the energy stored, is twice the mean kinetic
energy: with sliders and open contacts the strain energy is not defined without their history, the kinetic energy is,
and at resonance both swing equally far.

From phase: -1 / (w d(phase)/dw) along the response at constant force, at its maximum. There the amplitude is
stationary, hence the equivalent stiffness and damping too, and the slope is that of the linear oscillator of that
amplitude, however strong the nonlinearity; what remains is one mode's formula, and neighbours disturb it.
"""

import numpy as np

from updamp.hbm.newton.equation import Equation
from updamp.hbm.problem.system import Excitation
from updamp.hbm.resonance.resonance import ResonanceSolution


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
