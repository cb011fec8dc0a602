"""The tangent T of the elements' departure from stuck: block diagonal by element, zero where an element is stuck."""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.system import Departure, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Below this share of the reference stiffness a tangent is round-off of the Fourier transform, not slip.
NEGLIGIBLE = 1e-10


def apply_tangent(system: NonlinearSystem, departure: Departure, displacement: Floats) -> Floats:
    """T displacement: (n_relative, n_coefficients, ...) [m] -> same [N]"""
    forces = np.empty_like(displacement)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        n, d, c = tangent.shape[:3]
        motion = displacement[group.rows]
        product = tangent.reshape(n, d * c, d * c) @ motion.reshape(n, d * c, -1)
        forces[group.rows] = product.reshape(motion.shape)
    return forces


def active_rows(system: NonlinearSystem, departure: Departure) -> Integers:
    """Ascending relative rows whose element departs from its reference springs in that direction."""
    active = np.zeros(system.free.n_relative, dtype=bool)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        scale = np.maximum(system.reference_stiffness[group.rows], np.finfo(float).tiny)
        active[group.rows] = np.abs(tangent).max(axis=(2, 3, 4)) > NEGLIGIBLE * scale
    return np.flatnonzero(active)


def real_form(G: NDArray[np.complex128], k: int) -> Floats:
    """A complex receptance acting on (cos, sin) pairs: (rows, columns) -> (rows, width, columns, width)."""
    if k == 0:
        return G.real[:, None, :, None]
    return np.stack([np.stack([G.real, G.imag], axis=-1), np.stack([-G.imag, G.real], axis=-1)], axis=1)
