"""Rigid-body motion of a set of nodes, and six springs that hold a free component without straining it."""

from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class Support:
    """Springs to the ground.

    directions: (n_dofs, n_springs) [-]; stiffness: (n_springs,) [N/m]
    """

    directions: sparse.csc_array
    stiffness: Floats

    def added_to(self, matrix: sparse.bsr_array) -> sparse.bsr_array:
        if not len(self.stiffness):
            return matrix
        springs = (self.directions * self.stiffness) @ self.directions.T
        return sparse.bsr_array(matrix + sparse.bsr_array(springs, blocksize=(3, 3)))


def isostatic_support(nodes: Floats, stiffness: float) -> Support:
    """Three springs at one node, two at a second, one at a third (3-2-1), the nodes far apart.

    nodes: (n, 3) [m]; stiffness: of each spring [N/m]
    """
    first = int(np.linalg.norm(nodes - nodes.mean(axis=0), axis=1).argmax())
    second = int(np.linalg.norm(nodes - nodes[first], axis=1).argmax())
    line = (nodes[second] - nodes[first]) / np.linalg.norm(nodes[second] - nodes[first])
    across = nodes - nodes[first] - np.outer((nodes - nodes[first]) @ line, line)
    third = int(np.linalg.norm(across, axis=1).argmax())
    sideways = across[third] / np.linalg.norm(across[third])
    upright = np.cross(line, sideways)
    held = [(first, line), (first, sideways), (first, upright), (second, sideways), (second, upright), (third, upright)]
    rows = np.concatenate([3 * node + np.arange(3) for node, _ in held])
    values = np.concatenate([direction for _, direction in held])
    directions = sparse.csc_array((values, (rows, np.repeat(np.arange(6), 3))), shape=(3 * len(nodes), 6))
    return Support(directions, np.full(6, stiffness))
