"""Structural patches as parameters: springs, masses and dashpots on named points.

Each changes the dynamic stiffness by a matrix of rank one, dZ(w) d d^T, so that dG = -G d dZ d^T G; this is exact
at the present value of the patch, residual flexibility included, whether it is part of the model already or not.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.analysis.sensitivity_parameters import LawEntry, SolvedPoint
from updamp.hbm.newton.structure_response import Loads
from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]


def patch_direction(model: LinearModel, weights: Mapping[str, float]) -> Floats:
    """(n_rows,) the displacement sum of weight times point: {"tip": 1.0} to ground, {"a": 1.0, "b": -1.0} between two.

    raises: KeyError naming the points there are
    """
    chosen = np.zeros(model.n_rows)
    for point, weight in weights.items():
        chosen[model.row(point)] += weight
    return chosen


@dataclass(frozen=True, eq=False)
class _Patch:
    """direction: (n_rows,) displacement of the linear model's rows that the patch acts on"""

    direction: Floats
    law_entries: ClassVar[tuple[LawEntry, ...]] = ()

    def dynamic_stiffness(self, w: float) -> complex:
        """dZ/dp at the angular frequency w"""
        raise NotImplementedError

    def loads(self, point: SolvedPoint) -> Loads:
        harmonics, w = point.system.harmonics, point.equation.w
        rows = np.flatnonzero(self.direction)
        motion = self.direction[rows] @ point.motion.at(rows)[:, :, 0]
        force = np.zeros_like(motion)
        for k in harmonics.orders:
            harmonics.set_amplitude(force, k, -self.dynamic_stiffness(k * w) * harmonics.amplitude(motion, k))
        loads = Loads.none(point.equation.receptance, 1)
        loads.forces[rows, :, 0] = np.outer(self.direction[rows], force)
        return loads


@dataclass(frozen=True, eq=False)
class Spring(_Patch):
    """Stiffness [N/m]"""

    def dynamic_stiffness(self, w: float) -> complex:  # noqa: ARG002 - a spring is the same at all frequencies
        return 1.0


@dataclass(frozen=True, eq=False)
class Mass(_Patch):
    """Mass [kg]"""

    def dynamic_stiffness(self, w: float) -> complex:
        return -(w**2)


@dataclass(frozen=True, eq=False)
class Dashpot(_Patch):
    """Viscous damping [N s/m]"""

    def dynamic_stiffness(self, w: float) -> complex:
        return 1j * w
