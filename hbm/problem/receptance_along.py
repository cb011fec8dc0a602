"""The stuck structure's receptance at several frequencies at once.

Arrays carry the frequencies along their third axis, (rows, n_coefficients, n_frequencies, ...): what is done once for
all of them takes hardly longer than for one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.modal_algebra import ModalResponse
from updamp.hbm.problem.receptance import moving_part, set_moving
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ReceptanceAlong:
    """As `Receptance`. w: (n_frequencies,)"""

    system: NonlinearSystem
    w: Floats

    def apply(self, forces: Floats, rows: slice | Integers) -> Floats:
        """G forces, from the relative rows (n_relative, n_coefficients, n_frequencies, ...) to `rows`"""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        by_modes = product(stuck.phi[rows], self._through_modes(product(stuck.phi[:n].T, forces)))
        return by_modes + product(stuck.residual[rows, :n], forces) if stuck.has_residual else by_modes

    def excitation(self, row: int, amplitudes: Floats, rows: slice | Integers) -> Floats:
        """Displacement of `rows` under a force on one row, all elements stuck; amplitudes: (n_frequencies,) [N]"""
        stuck = self.system.stuck
        response = product(stuck.phi[rows], self._through_modes(self._modal_load(row, amplitudes)))
        response[:, self._first] += np.multiply.outer(stuck.residual[rows, row], amplitudes)
        return response

    def motion(self, row: int, amplitudes: Floats, forces: Floats, rows: slice | Integers) -> Floats:
        """`excitation` less `apply`, by one modal solution"""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        loads = self._modal_load(row, amplitudes) - product(stuck.phi[:n].T, forces)
        response = product(stuck.phi[rows], self._through_modes(loads))
        if stuck.has_residual:
            response[:, self._first] += np.multiply.outer(stuck.residual[rows, row], amplitudes)
            response -= product(stuck.residual[rows, :n], forces)
        return response

    def motion_rate(self, row: int, amplitudes: Floats, forces: Floats, rows: slice | Integers) -> Floats:
        """Derivative of `motion` by the angular frequency, under forces held constant"""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        loads = self._modal_load(row, amplitudes) - product(stuck.phi[:n].T, forces)
        response = np.zeros_like(loads)
        set_moving(response, self._moving.rate_times(moving_part(loads, len(self._orders))))
        return product(stuck.phi[rows], response)

    def _through_modes(self, loads: Floats) -> Floats:
        response = np.empty_like(loads)
        if 0 in self.system.harmonics.orders:
            response[:, 0] = (loads[:, 0].T / self.system.stuck.omega_squared).T
        set_moving(response, self._moving.times(moving_part(loads, len(self._orders))))
        return response

    def _modal_load(self, row: int, amplitudes: Floats) -> Floats:
        """(m, n_coefficients, n_frequencies) [N kg^-1/2]"""
        shape = self.system.stuck.phi[row]
        load = np.zeros((len(shape), self.system.harmonics.n_coefficients, len(amplitudes)))
        load[:, self._first] = np.multiply.outer(shape, amplitudes)
        return load

    @cached_property
    def _moving(self) -> ModalResponse:
        return self.system.stuck.modal_inverse.at(self.w, self._orders)

    @cached_property
    def _orders(self) -> tuple[int, ...]:
        return tuple(k for k in self.system.harmonics.orders if k)

    @property
    def _first(self) -> int:
        """Place of the cosine of the first harmonic"""
        return self.system.harmonics.slices[1].start


def product(matrix: Floats, array: Floats) -> Floats:
    """The matrix times the first axis of the array"""
    return np.asarray(matrix @ array.reshape(len(array), -1)).reshape(len(matrix), *array.shape[1:])
