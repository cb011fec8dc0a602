"""The stuck structure's response to many loads at once.

Arrays carry the loads along their last axis: (rows, n_coefficients, n_loads).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.equation import Equation
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Excitation

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads on the stuck structure.

    forces: (n_rows, n_coefficients, n_loads) on the rows of the linear model [N]
    modal: (m, n_coefficients, n_loads) on the stuck modes, in addition to what the forces do to them [N kg^-1/2]
    """

    forces: Floats
    modal: Floats

    @staticmethod
    def none(receptance: Receptance, n_loads: int) -> "Loads":
        stuck, c = receptance.system.stuck, receptance.system.harmonics.n_coefficients
        return Loads(np.zeros((stuck.n_rows, c, n_loads)), np.zeros((len(stuck.omega_squared), c, n_loads)))

    @staticmethod
    def stacked(loads: "list[Loads]") -> "Loads":
        return Loads(
            np.concatenate([load.forces for load in loads], axis=2),
            np.concatenate([load.modal for load in loads], axis=2),
        )


@dataclass(frozen=True, eq=False)
class StructureMotion:
    """Response to loads: phi modal + residual forces.

    modal: (m, n_coefficients, n_loads) modal coordinates [m kg^1/2]
    forces: (n_rows, n_coefficients, n_loads) forces that act on the residual flexibility [N]
    """

    receptance: Receptance
    modal: Floats
    forces: Floats

    def at(self, rows: slice | Integers) -> Floats:
        """(len(rows), n_coefficients, n_loads) displacement [m]"""
        stuck = self.receptance.system.stuck
        n, c, p = self.forces.shape
        by_modes = stuck.phi[rows] @ self.modal.reshape(-1, c * p)
        if stuck.has_residual:
            by_modes += stuck.residual[rows] @ self.forces.reshape(n, c * p)
        return by_modes.reshape(-1, c, p)


def respond(receptance: Receptance, loads: Loads) -> StructureMotion:
    modal = receptance.through_modes(_generalised(receptance, loads))
    return StructureMotion(receptance, modal, loads.forces)


def all_loads(equation: Equation, excitation: Excitation) -> Loads:
    """Everything that acts on the stuck structure at a solved point: the excitation less the elements' departure."""
    receptance = equation.receptance
    loads = Loads.none(receptance, 1)
    loads.forces[: receptance.system.stuck.n_relative, :, 0] = -equation.departure.value
    harmonics = receptance.system.harmonics
    loads.forces[excitation.row, harmonics.slices[1].start, 0] += excitation.force
    return loads


def frequency_rate(receptance: Receptance, loads: Loads) -> Floats:
    """d/dw of the modal coordinates under loads held constant; the residual flexibility does not depend on w."""
    return receptance.rate_through_modes(_generalised(receptance, loads))


def _generalised(receptance: Receptance, loads: Loads) -> Floats:
    n, c, p = loads.forces.shape
    return (receptance.system.stuck.phi.T @ loads.forces.reshape(n, c * p)).reshape(-1, c, p) + loads.modal
