"""Six springs that hold a free component without straining it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Floats = NDArray[np.float64]


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
