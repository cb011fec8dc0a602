"""The residual of harmonic balance at one point, with what Newton's method needs of it, and first guesses."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.active_forces import DirectForces
from updamp.hbm.newton.jacobian import Jacobian, factorise
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.receptance_along import ReceptanceAlong
from updamp.hbm.problem.system import Departure, Excitation, Forcing, NonlinearSystem

Floats = NDArray[np.float64]

# The mean position counts in the size of a displacement up to so many times the vibration: a larger one does not make
# a solution better.
_MOST_MEAN = 1000.0
# A residual stands for a force at the contacts: itself times their stiffness. It is measured by so many times the
# displacement at which the stiffest contact carries the excitation: 1e-9 of that is 1e-4 of the excitation.
_CARRYING = 1e5
# What round-off lets a residual be known to, 1e-12 of the displacement, is 1e-9 of this share of it.
_KNOWN = 1e-3
# A displacement is summed from what each mode contributes, and known to some 1e-15 of the sum of their magnitudes: 1e-9
# of this share of it. Far from where a structure is driven they may cancel to less.
_SUMMED = 1e-6


@dataclass(frozen=True, eq=False)
class Equation:
    """Residual r(x, w) = x - x_lin(w) + G(w) g(x) at one point, with all that Newton needs.

    w: [rad/s], or what varies along the branch in its place; residual: (n_relative, n_coefficients) [m]
    applied: the excitation there
    """

    x: Floats
    w: float
    receptance: Receptance
    departure: Departure
    residual: Floats
    applied: Excitation

    @property
    def force(self) -> float:
        """Amplitude of the excitation [N]"""
        return self.applied.force

    @property
    def error(self) -> float:
        """Largest residual over `size`; infinite where not finite."""
        error = np.abs(self.residual).max() / self.size
        return float(error) if np.isfinite(error) else np.inf

    @property
    def size(self) -> float:
        """What a residual is measured by [m]: the largest displacement (`displacement_size`), or less, where contacts
        are so stiff that the residual would stand for forces that count beside the excitation."""
        system = self.receptance.system
        displacement, stiffest = displacement_size(system, self.x), system.reference_stiffness.max(initial=0.0)
        if self.force * stiffest:
            displacement = min(displacement, max(_CARRYING * abs(self.force) / stiffest, _KNOWN * displacement))
        return max(displacement, self.least)

    @cached_property
    def least(self) -> float:
        """The least displacement [m] that a residual, or the length of a step, is measured by: one that stands above
        the round-off of the modal sums that it is made of."""
        return _SUMMED * self.receptance.summed(self.applied)

    def factorised(self, near: DirectForces | None = None) -> Jacobian:
        """near: factors at a similar point, to do without new ones

        raises: scipy.linalg.LinAlgError where a tangent is not finite
        """
        return factorise(self.receptance, self.departure, near)

    def frequency_derivative(self, excitation: Forcing) -> Floats:
        """dr/dw"""
        receptance, (w_rate, force_rate) = self.receptance, excitation.rates(self.w)
        applied = excitation.at(self.w)[1]
        rate = np.zeros_like(self.x)
        if w_rate:
            rate -= w_rate * receptance.motion_rate(applied, self.departure.value)
            if self.departure.frequency_derivative.any():
                rate += w_rate * receptance.apply(self.departure.frequency_derivative)
        if force_rate:
            rate -= receptance.excitation(Excitation(applied.row, force_rate))
        return rate


def displacement_size(system: NonlinearSystem, x: Floats) -> float:
    """Largest displacement [m], the mean position's limited to so many times the vibration's."""
    largest = np.abs(x).max()
    if 0 in system.harmonics.orders:
        vibration = np.abs(np.delete(x, system.harmonics.slices[0], axis=1)).max(initial=0.0)
        largest = min(largest, _MOST_MEAN * vibration) if vibration else largest
    return float(max(largest, np.finfo(float).tiny))


def evaluate(system: NonlinearSystem, excitation: Forcing, x: Floats, w: float) -> Equation:
    frequency, applied = excitation.at(w)
    receptance = Receptance(system, frequency)
    departure = system.departure(x, frequency)
    residual = x - receptance.motion(applied, departure.value)
    return Equation(x, w, receptance, departure, residual, applied)


def evaluate_together(
    system: NonlinearSystem, excitation: Forcing, places: Sequence[tuple[Floats, float]]
) -> list[Equation]:
    """As `evaluate`, at several places (x, w) at once, which takes hardly longer than at one."""
    applied = [excitation.at(w) for _, w in places]
    x, frequencies = np.stack([x for x, _ in places], axis=2), np.array([frequency for frequency, _ in applied])
    forces = np.array([there.force for _, there in applied])
    departures = system.departures(x, frequencies)
    value = np.stack([departure.value for departure in departures], axis=2)
    rows = slice(system.free.n_relative)
    residual = x - ReceptanceAlong(system, frequencies).motion(applied[0][1].row, forces, value, rows)
    return [
        Equation(of, w, Receptance(system, applied[i][0]), departures[i], residual[..., i].copy(), applied[i][1])
        for i, (of, w) in enumerate(places)
    ]


def residual_alone(system: NonlinearSystem, excitation: Forcing, x: Floats, w: float) -> Floats:
    """(n_relative, n_coefficients) [m], without the tangents, which are most of the cost of `evaluate`."""
    frequency, applied = excitation.at(w)
    receptance = Receptance(system, frequency)
    return x - receptance.motion(applied, system.departure_value(x, frequency))


def linear_solution(system: NonlinearSystem, w: float, excitation: Excitation) -> Floats:
    """All elements stuck: the natural first guess. raises: ValueError for a row that the model does not have"""
    system.refuse_row(excitation.row)
    return Receptance(system, w).excitation(excitation)


def open_solution(system: NonlinearSystem, w: float, excitation: Excitation) -> Floats:
    """No contact at all, about the position at rest: a guess where the force is large."""
    n = system.free.n_relative
    amplitude = excitation.force * system.free.receptance(w, slice(n), np.array([excitation.row]))[:, 0]
    response = np.zeros((n, system.harmonics.n_coefficients))
    system.harmonics.set_amplitude(response, 1, amplitude)
    return response
