"""The stuck structure's receptance at one frequency."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.modal_algebra import ModalResponse
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Receptance:
    """G = phi D^-1 phi^T + residual, D the dynamic stiffness of the stuck modes: applied, never formed whole."""

    system: NonlinearSystem
    w: float

    @cached_property
    def modal(self) -> Mapping[int, Complex]:
        """harmonic k -> inverse of the modal dynamic stiffness at k w, (m, m): costlier than what is done without"""

        def of(k: int) -> Complex:
            """A structure that can move as a whole has no static one, and is not solved with harmonic 0."""
            if k == 0:
                return np.diag(1 / self.system.stuck.omega_squared).astype(np.complex128)
            return self.moving.matrix(self.moving_orders.index(k))

        return {k: of(k) for k in self._orders}

    def apply(self, forces: Floats, rows: slice | Integers | None = None) -> Floats:
        """G forces, from the relative rows (n_relative, n_coefficients) to `rows` (default: the same)."""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        rows = slice(n) if rows is None else rows
        by_modes = stuck.phi[rows] @ self.through_modes(stuck.phi[:n].T @ forces)
        return by_modes + thin_product(stuck.residual[rows, :n], forces) if stuck.has_residual else by_modes

    def through_modes(self, loads: Floats) -> Floats:
        """Modal coordinates (m, n_coefficients, ...) under modal loads like them."""
        response = np.empty_like(loads)
        if 0 in self._orders:
            response[:, 0] = (loads[:, 0].T / self.system.stuck.omega_squared).T
        set_moving(response, self.moving.times(moving_part(loads, len(self.moving_orders))))
        return response

    def rate_through_modes(self, loads: Floats) -> Floats:
        """d/dw of `through_modes` under loads held constant"""
        response = np.zeros_like(loads)
        set_moving(response, self.moving.rate_times(moving_part(loads, len(self.moving_orders))))
        return response

    def excitation(self, excitation: Excitation, rows: slice | Integers | None = None) -> Floats:
        """Displacement of `rows` (default: the relative ones) under the excitation alone, all elements stuck."""
        stuck = self.system.stuck
        rows = slice(stuck.n_relative) if rows is None else rows
        response = stuck.phi[rows] @ self.through_modes(self._modal_load(excitation))
        response[:, self.system.harmonics.slices[1].start] += excitation.force * stuck.residual[rows, excitation.row]
        return np.asarray(response)

    def summed(self, excitation: Excitation) -> float:
        """Largest sum of the magnitudes [m] of what each mode, and the residual flexibility, contribute to a relative
        row's motion under the excitation alone."""
        stuck, harmonics = self.system.stuck, self.system.harmonics
        first = self.through_modes(self._modal_load(excitation))[:, harmonics.slices[1]]
        shares = np.abs(stuck.phi[: stuck.n_relative]) @ np.linalg.norm(first, axis=1)
        shares += np.abs(excitation.force * stuck.residual[: stuck.n_relative, excitation.row])
        return float(shares.max(initial=0.0))

    def motion(self, excitation: Excitation, forces: Floats, rows: slice | Integers | None = None) -> Floats:
        """`excitation` less `apply`, by one modal solution: of `rows` where the elements carry these forces."""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        rows = slice(n) if rows is None else rows
        response = stuck.phi[rows] @ self.through_modes(self._modal_load(excitation) - stuck.phi[:n].T @ forces)
        if stuck.has_residual:
            response[:, self.system.harmonics.slices[1].start] += (
                excitation.force * stuck.residual[rows, excitation.row]
            )
            response -= thin_product(stuck.residual[rows, :n], forces)
        return np.asarray(response)

    def motion_rate(self, excitation: Excitation, forces: Floats, rows: slice | Integers | None = None) -> Floats:
        """d/dw of `motion` under forces held constant."""
        stuck, n = self.system.stuck, self.system.stuck.n_relative
        loads = self._modal_load(excitation) - stuck.phi[:n].T @ forces
        return np.asarray(stuck.phi[slice(n) if rows is None else rows] @ self.rate_through_modes(loads))

    def block(self, k: int, rows: Integers, columns: Integers) -> Complex:
        """G_k between some of the relative rows, by products of real matrices, which cost half of mixed ones."""
        stuck = self.system.stuck
        left = (stuck.phi[rows] @ np.ascontiguousarray(self.modal[k]).view(np.float64)).view(np.complex128)
        through_modes = (stuck.phi[columns] @ np.ascontiguousarray(left.T).view(np.float64)).view(np.complex128).T
        return through_modes + stuck.residual[np.ix_(rows, columns)]

    @cached_property
    def moving(self) -> ModalResponse:
        """Of all harmonics but the static one, to which damping does not belong"""
        return self.system.stuck.modal_inverse.at(self.w, self.moving_orders)

    @property
    def _orders(self) -> tuple[int, ...]:
        return self.system.harmonics.orders

    @cached_property
    def moving_orders(self) -> tuple[int, ...]:
        return tuple(k for k in self._orders if k)

    def _modal_load(self, excitation: Excitation) -> Floats:
        """(m, n_coefficients) [N kg^-1/2]"""
        shape, harmonics = self.system.stuck.phi[excitation.row], self.system.harmonics
        load = np.zeros((len(shape), harmonics.n_coefficients))
        load[:, harmonics.slices[1].start] = excitation.force * shape
        return load


def moving_part(loads: Floats, n_moving: int) -> Complex:
    """(m, n_moving, ...) complex amplitudes of (m, n_coefficients, ...), without the mean"""
    moving = loads[:, loads.shape[1] - 2 * n_moving :]
    pairs = moving.reshape(len(loads), -1, 2, *loads.shape[2:])
    return np.asarray(pairs[:, :, 0] - 1j * pairs[:, :, 1])


def set_moving(response: Floats, amplitudes: Complex) -> None:
    """Writes the coefficients of `amplitudes` into (m, n_coefficients, ...)."""
    start = response.shape[1] - 2 * amplitudes.shape[1]
    response[:, start::2], response[:, start + 1 :: 2] = amplitudes.real, -amplitudes.imag


# Up to a million multiplications OpenBLAS multiplies matrices as they lie in memory. Larger ones it rearranges first,
# which takes several times as long where one of them has a few columns: 438 x 438 x 7: 0.2 to 0.6 ms, in parts 0.06.
_AS_THEY_LIE = 900_000


def thin_product(matrix: Floats, columns: Floats) -> Floats:
    """matrix @ columns, (n, n_columns) of few columns, some rows of the matrix at a time."""
    rows = max(1, _AS_THEY_LIE // max(1, columns.size))
    product = np.empty((len(matrix), columns.shape[1]))
    for start in range(0, len(matrix), rows):
        np.matmul(matrix[start : start + rows], columns, out=product[start : start + rows])
    return product
