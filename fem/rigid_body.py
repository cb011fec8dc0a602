"""Rigid-body motion of a set of nodes."""

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

Floats = NDArray[np.float64]


def rigid_body_fields(nodes: Floats) -> Floats:
    """Unit translations along x, y, z and small unit rotations about the axes through the nodes' mean.

    nodes: (n, 3) [m] -> (3 n, 6), degrees of freedom interleaved
    """
    arms = nodes - nodes.mean(axis=0)
    fields = np.zeros((len(nodes), 3, 6))
    fields[:, :, :3] = np.eye(3)
    for axis in range(3):
        fields[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arms)
    return fields.reshape(-1, 6)


def rigid_body_modes(nodes: Floats, mass: sparse.csr_array) -> Floats:
    """Mass-orthonormal rigid-body modes (3 n, 6): translations first, then rotations about the centre of mass.

    Gram-Schmidt through the Cholesky factor of the 6 x 6 mass; a second pass takes the round-off of the first.
    """
    fields = rigid_body_fields(nodes)
    for _ in range(2):
        gram = fields.T @ (mass @ fields)
        fields = linalg.solve_triangular(linalg.cholesky(gram, lower=True), fields.T, lower=True).T
    return np.asfortranarray(fields)
