"""What can be read off a solved point: displacement anywhere, force loops, contact states, and the energy a cycle:
work of the excitation, loss by friction, loss in the material.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import SEPARATED, SLIP, CompiledStates, FrictionLaw
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.equation import Equation
from updamp.hbm.problem.elements import ElementGroup, compiled_forces, loop_areas, over_period
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

LOOP_SAMPLES = 512  # a period, of one force loop
LOSS_SAMPLES = 1024  # of the loops whose areas are the loss


class ContactState(IntEnum):
    """Over a period, as Pesaresi et al. (2017) Fig. 18 distinguish."""

    STUCK = 0
    STICK_SLIP = 1
    SEPARATING = 2
    NEVER_IN_CONTACT = 3


def response(equation: Equation, excitation: Excitation, rows: Integers) -> Floats:
    """(len(rows), n_coefficients) displacement of rows of the linear model, all contacts' forces included [m]."""
    receptance = equation.receptance
    return receptance.motion(excitation, equation.departure.value, rows)


def contact_states(system: NonlinearSystem, x: Floats, w: float, time_samples: int = 256) -> Integers:
    """(n_elements,) ContactState of each friction element, group by group; other elements (springs, dampers) have none.

    x: (n_relative, n_coefficients) [m]
    raises: TypeError where no group's law has stick, slip and separation
    """
    states = []
    if not any(isinstance(group.law, FrictionLaw) for group in system.groups):
        laws = ", ".join(type(group.law).__name__ for group in system.groups)
        raise TypeError(f"{laws}: no contact states: choose a law with friction")
    for group in system.groups:
        if not isinstance(group.law, FrictionLaw):
            continue
        states.append(_states_of(group, group.law, x[group.rows], w, system.harmonics, time_samples))
    return np.concatenate(states)


def _states_of(
    group: ElementGroup, law: FrictionLaw, motion: Floats, w: float, harmonics: Harmonics, time_samples: int
) -> Integers:
    """law: of the group; motion: (n_elements, directions, n_coefficients) [m]"""
    compiled = compiled_forces(law, harmonics, time_samples)
    if isinstance(compiled, CompiledStates):
        states = np.full(len(motion), int(ContactState.STUCK))
        active = group.may_slip_or_separate(motion, harmonics, time_samples)
        states[active] = compiled.contact_states(active, motion, group.values)
        return states
    _, state = over_period(group, law.state, motion, w, harmonics, time_samples)
    open_, slips = state == SEPARATED, (state == SLIP).any(axis=1)
    label = np.where(slips, ContactState.STICK_SLIP, ContactState.STUCK)
    label = np.where(open_.any(axis=1), ContactState.SEPARATING, label)
    return np.asarray(np.where(open_.all(axis=1), ContactState.NEVER_IN_CONTACT, label))


def force_loop(system: NonlinearSystem, x: Floats, w: float, element: int) -> tuple[Floats, Floats]:
    """Relative displacement (n_time, d) [m] and force (n_time, d) [N] of one element over a period.

    element: counted through the groups
    raises: IndexError naming how many there are
    """
    first = 0
    for group in system.groups:
        if element < first + len(group.rows):
            one = slice(element - first, element - first + 1)
            parameters = type(group.values)(*(value[one] for value in group.values))
            alone = ElementGroup(group.law, parameters, group.rows[one])
            motion, force = over_period(alone, group.law.force, x[alone.rows], w, system.harmonics, LOOP_SAMPLES)
            return motion[0], force[0]
        first += len(group.rows)
    raise IndexError(f"element {element}: the system has {first}, numbered from 0")


def work_in(system: NonlinearSystem, excitation: Excitation, response: Floats) -> float:
    """pi F X_s1 [J] of force F cos(w t); response: (n_coefficients,) displacement of the excited row [m]."""
    return float(np.pi * excitation.force * -system.harmonics.amplitude(response, 1).imag)


def friction_loss(system: NonlinearSystem, x: Floats, w: float) -> Floats:
    """Area of each element's force loop, sum of f dx over a period: (n_elements,) [J].

    Integrated in time on a grid of its own, so that comparing it with the other energies tests the balance.
    x: (n_relative, n_coefficients) [m]
    """
    areas = [loop_areas(group, x[group.rows], w, system.harmonics, LOSS_SAMPLES) for group in system.groups]
    return np.concatenate(areas)


def friction_share(loss: float, work: float) -> float:
    """Friction loss over the work of the excitation, to twelve digits behind the point: where all contacts stick a sum
    over closed loops leaves 1e-16 of either sign."""
    return round(loss / work, 12) + 0.0


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
