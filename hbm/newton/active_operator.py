"""y + T G y on the rows of elements that depart from stuck, to be applied many times."""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.receptance import Receptance, thin_product
from updamp.hbm.problem.system import Departure

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class ActiveOperator:
    """Whatever belongs to the active rows, and to the elements they are of, is picked out once.

    rows: (n_active,) ascending relative rows on which y is not zero
    """

    def __init__(self, receptance: Receptance, departure: Departure, rows: Integers) -> None:
        system, stuck = receptance.system, receptance.system.stuck
        number = np.full(system.free.n_relative, -1)
        number[rows] = np.arange(len(rows))
        self._tangents: list[Floats] = []
        moving = []
        for group, tangent in zip(system.groups, departure.tangents, strict=True):
            chosen = np.flatnonzero((number[group.rows] >= 0).any(axis=1))
            n, d, c = len(chosen), *tangent.shape[1:3]
            self._tangents.append(tangent[chosen].reshape(n, d * c, d * c))
            moving.append(group.rows[chosen].ravel())
        moved = np.concatenate(moving)
        # where each active row stands among those of the elements
        self._wanted = np.argsort(moved)[np.searchsorted(np.sort(moved), rows)]
        self._receptance, self._coefficients = receptance, system.harmonics.n_coefficients
        self._to_modes, self._from_modes = np.ascontiguousarray(stuck.phi[rows].T), stuck.phi[moved]
        self._residual = stuck.residual[np.ix_(moved, rows)] if stuck.has_residual else None

    def __call__(self, active: Floats) -> Floats:
        """(n_active n_coefficients,) -> same"""
        return self.of_many(active.reshape(-1, self._coefficients, 1)).ravel()

    def of_many(self, forces: Floats) -> Floats:
        """(n_active, n_coefficients, n) -> same"""
        c, p = forces.shape[1:]
        columns = forces.reshape(len(forces), c * p)
        through = self._receptance.through_modes((self._to_modes @ columns).reshape(-1, c, p))
        motion = self._from_modes @ through.reshape(-1, c * p)
        if self._residual is not None:
            motion += thin_product(self._residual, columns)
        changed, start = np.empty_like(motion), 0
        for tangent in self._tangents:
            n, width = tangent.shape[:2]
            stop = start + n * width // c
            product = tangent @ motion[start:stop].reshape(n, width, p)
            changed[start:stop] = product.reshape(-1, c * p)
            start = stop
        return forces + changed[self._wanted].reshape(forces.shape)
