"""The exact Jacobian J = I + G T of the residual, inverted through the rows that depart from stuck.

With S the rows where the tangent T is not zero: J^-1 r = r - G_:S (I + T_S: G_:S)^-1 T_S: r, a dense system of
|S| n_coefficients unknowns instead of all of them.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.system import Departure, NonlinearSystem, Receptance

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Below this share of the reference stiffness a tangent is round-off of the Fourier transform, not slip.
NEGLIGIBLE = 1e-10


@dataclass(frozen=True, eq=False)
class Jacobian:
    """Factorised; `solve` may be called any number of times.

    rows: (n_active,) relative rows with a departure
    """

    receptance: Receptance
    departure: Departure
    rows: Integers
    factors: tuple[Floats, NDArray[np.int32]] | None

    @property
    def n_active(self) -> int:
        return len(self.rows)

    def solve(self, right: Floats) -> Floats:
        """J^-1 right: (n_relative, n_coefficients) -> same"""
        if self.factors is None:
            return right
        active = self.apply_tangent(right)[self.rows]
        y = scipy.linalg.lu_solve(self.factors, active.ravel(), check_finite=False)
        forces = np.zeros_like(right)
        forces[self.rows] = y.reshape(active.shape)
        return right - self.receptance.apply(forces)

    def apply_tangent(self, displacement: Floats) -> Floats:
        """T displacement: (n_relative, n_coefficients) [m] -> [N]"""
        return apply_tangent(self.receptance.system, self.departure, displacement)


def apply_tangent(system: NonlinearSystem, departure: Departure, displacement: Floats) -> Floats:
    forces = np.zeros_like(displacement)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        n, d, c = tangent.shape[:3]
        product = tangent.reshape(n, d * c, d * c) @ displacement[group.rows].reshape(n, d * c, 1)
        forces[group.rows] = product.reshape(n, d, c)
    return forces


def factorise(receptance: Receptance, departure: Departure) -> Jacobian:
    """raises: scipy.linalg.LinAlgError where a tangent is not finite"""
    rows = active_rows(receptance.system, departure)
    if len(rows) == 0:
        return Jacobian(receptance, departure, rows, None)
    matrix = _active_matrix(receptance, departure, rows)
    if not np.isfinite(matrix).all():
        raise scipy.linalg.LinAlgError("the tangent of a contact element is not finite")
    return Jacobian(receptance, departure, rows, scipy.linalg.lu_factor(matrix, overwrite_a=True, check_finite=False))


def active_rows(system: NonlinearSystem, departure: Departure) -> Integers:
    """Ascending relative rows whose element departs from its reference springs in that direction."""
    active = np.zeros(system.free.n_relative, dtype=bool)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        scale = np.maximum(system.reference_stiffness[group.rows], np.finfo(float).tiny)
        active[group.rows] = np.abs(tangent).max(axis=(2, 3, 4)) > NEGLIGIBLE * scale
    return np.flatnonzero(active)


def _active_matrix(receptance: Receptance, departure: Departure, rows: Integers) -> Floats:
    """I + T_S: G_:S, ordered (row, coefficient)."""
    system = receptance.system
    n_coefficients, n_active = system.harmonics.n_coefficients, len(rows)
    matrix = np.zeros((n_active, n_coefficients, n_active, n_coefficients))
    place = np.full(system.free.n_relative, -1)
    place[rows] = np.arange(n_active)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        chosen = np.flatnonzero((place[group.rows] >= 0).any(axis=1))
        element_rows = group.rows[chosen]
        for k, part in system.harmonics.slices.items():
            product = _tangent_times_receptance(receptance, tangent[chosen][..., part], k, element_rows, rows)
            wanted = place[element_rows] >= 0
            matrix[place[element_rows][wanted], :, :, part] = product[wanted]
    matrix = matrix.reshape(n_active * n_coefficients, -1)
    matrix[np.diag_indices_from(matrix)] += 1
    return matrix


def _tangent_times_receptance(
    receptance: Receptance, tangent: Floats, k: int, element_rows: Integers, columns: Integers
) -> Floats:
    """T G_k: tangent (n, d, n_coefficients, d, width of k) -> (n, d, n_coefficients, n_columns, width of k)."""
    n, d, c, _, width = tangent.shape
    G = real_form(receptance.block(k, element_rows.ravel(), columns), k)  # (n d, width, n_columns, width)
    product = tangent.reshape(n, d * c, d * width) @ G.reshape(n, d * width, -1)
    return product.reshape(n, d, c, len(columns), width)


def real_form(G: NDArray[np.complex128], k: int) -> Floats:
    """A complex receptance acting on (cos, sin) pairs: (rows, columns) -> (rows, width, columns, width)."""
    if k == 0:
        return G.real[:, None, :, None]
    return np.stack([np.stack([G.real, G.imag], axis=-1), np.stack([-G.imag, G.real], axis=-1)], axis=1)
