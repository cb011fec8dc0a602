"""Derivatives of a solved point with respect to parameters, from the Jacobian it was solved with.

J dx/dp = -dr/dp - dr/dw dw/dp, where dw/dp follows from what is held (hbm/analysis/held_quantities.py). All parameters
and the frequency are solved for together. At the top of a curve the derivative of the amplitude is that of the peak
whatever is held, since the amplitude does not change along the branch there.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.analysis.held_quantities import FixedFrequency, HeldQuantity
from updamp.hbm.analysis.sensitivity_parameters import Parameter, SolvedPoint
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.many_right_sides import solve_with_forces
from updamp.hbm.newton.newton import Solution
from updamp.hbm.newton.structure_response import Loads, StructureMotion, frequency_rate, respond
from updamp.hbm.problem.system import Excitation

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives in the order of the parameters, each per unit of its parameter.

    displacement: (n_parameters, n_relative, n_coefficients) of the relative displacements [m]
    w: (n_parameters,) of the angular frequency [rad/s]
    response: (n_parameters, n_points, n_coefficients) of the named points [m]
    response_value: (n_points, n_coefficients) the response itself [m]
    """

    points: tuple[str, ...]
    harmonics: Harmonics
    displacement: Floats
    w: Floats
    response: Floats
    response_value: Floats

    @property
    def frequency(self) -> Floats:
        """(n_parameters,) [Hz]"""
        return self.w / (2 * np.pi)

    def amplitude(self, point: str, k: int = 1) -> Complex:
        """(n_parameters,) derivative of the complex amplitude [m]; raises: ValueError where there is no such point"""
        return self.harmonics.amplitude(self.response[:, self._place(point)], k)

    def size(self, point: str, k: int = 1) -> Floats:
        """(n_parameters,) derivative of the amplitude's size [m]"""
        value = self.harmonics.amplitude(self.response_value[self._place(point)], k)
        return np.asarray((self.amplitude(point, k) * value.conj()).real / np.abs(value))

    def _place(self, point: str) -> int:
        if point not in self.points:
            raise ValueError(f"no point '{point}' among the sensitivities; there are {', '.join(self.points)}")
        return self.points.index(point)


def sensitivities(
    solution: Solution,
    excitation: Excitation,
    parameters: Sequence[Parameter],
    held: HeldQuantity | None = None,
    points: tuple[str, ...] = (),
) -> Sensitivities:
    """Of a converged point; `held` is the frequency by default.

    raises: ValueError for a point that is not converged, or where what is held does not fix the frequency;
        RuntimeError where the Jacobian is singular (at a fold: hold the arc)
    """
    held = held or FixedFrequency()
    jacobian, equation = solution.jacobian, solution.equation
    if not solution.converged or jacobian is None:
        raise ValueError(f"the point is not solved ({solution.status.value}): {solution.status.advice}")
    point = SolvedPoint(equation, excitation, tuple(entry for p in parameters for entry in p.law_entries))
    motion = _motion_at_held_displacement(point, parameters)
    held_motion = motion.at(slice(point.system.free.n_relative))
    dx, forces = solve_with_forces(jacobian, equation.departure, held_motion)
    rows = np.array([*held.rows, *(point.system.free.row(name) for name in points)], dtype=np.int64)
    dy = _response(point, motion, forces, rows)
    dw = _frequency_shift(held, dx, dy[: len(held.rows)])
    observed = dy[len(held.rows) :]
    return Sensitivities(
        points=points,
        harmonics=point.system.harmonics,
        displacement=(dx[..., :-1] + dx[..., -1:] * dw).transpose(2, 0, 1),
        w=dw,
        response=(observed[..., :-1] + observed[..., -1:] * dw).transpose(2, 0, 1),
        response_value=point.motion.at(rows[len(held.rows) :])[..., 0],
    )


def _motion_at_held_displacement(point: SolvedPoint, parameters: Sequence[Parameter]) -> StructureMotion:
    """The structure's response to each parameter, and last to the frequency, with the relative displacements held as
    the elements see them: on the relative rows it is -dr/dp and -dr/dw."""
    receptance = point.equation.receptance
    by_frequency = Loads.none(receptance, 1)
    by_frequency.forces[: point.system.free.n_relative, :, 0] = -point.equation.departure.frequency_derivative
    motion = respond(receptance, Loads.stacked([*(p.loads(point) for p in parameters), by_frequency]))
    motion.modal[..., -1:] += frequency_rate(receptance, point.loads)
    return motion


def _response(point: SolvedPoint, motion: StructureMotion, forces: Floats, rows: NDArray[np.int64]) -> Floats:
    """(len(rows), n_coefficients, n) change of the rows: directly, and through the change of the elements' forces."""
    receptance = point.equation.receptance
    through_elements = Loads.none(receptance, forces.shape[2])
    through_elements.forces[: len(forces)] = -forces
    return motion.at(rows) + respond(receptance, through_elements).at(rows)


def _frequency_shift(held: HeldQuantity, dx: Floats, dy: Floats) -> Floats:
    """dw/dp such that the condition does not change; the last column is the change by the frequency itself."""
    n = dx.shape[2]
    change = held.change(dx, np.concatenate([np.zeros(n - 1), np.ones(1)]), dy)
    if not np.isfinite(change).all() or change[-1] == 0:
        raise ValueError(f"{type(held).__name__} does not fix the frequency at this point: hold something else")
    return np.asarray(-change[:-1] / change[-1])
