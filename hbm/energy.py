"""Energy a cycle: work of the excitation, friction loss, material loss."""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.elements import loop_areas
from updamp.hbm.newton import Equation
from updamp.hbm.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]


def work_in(system: NonlinearSystem, excitation: Excitation, response: Floats) -> float:
    """pi F X_s1 [J] of force F cos(w t); response: (n_coefficients,) displacement of the excited row [m]."""
    return float(np.pi * excitation.force * -system.harmonics.amplitude(response, 1).imag)


def friction_loss(system: NonlinearSystem, x: Floats, w: float, time_samples: int = 1024) -> Floats:
    """Area of each element's force loop, sum of f dx over a period: (n_elements,) [J].

    Integrated in time on a grid of its own, so that comparing it with the other energies tests the balance.
    x: (n_relative, n_coefficients) [m]
    """
    areas = [loop_areas(group, x[group.rows], w, system.harmonics, time_samples) for group in system.groups]
    return np.concatenate(areas)


def material_loss(equation: Equation, excitation: Excitation) -> float:
    """pi sum_k k q_k^H D_k q_k [J], D_k the damping of the modes; the residual flexibility is taken as undamped."""
    system, receptance = equation.receptance.system, equation.receptance
    stuck, harmonics = system.stuck, system.harmonics
    loads = -stuck.phi[: stuck.n_relative].T @ equation.departure.value
    total = 0.0
    for k in harmonics.orders:
        if k == 0:
            continue
        load = harmonics.amplitude(loads, k)
        if k == 1:
            load = load + excitation.force * stuck.phi[excitation.row]
        q = receptance.modal[k] @ load
        damping = stuck.hysteretic + k * receptance.w * stuck.viscous
        total += np.pi * k * float(np.real(q.conj() @ damping @ q))
    return total
