"""Quality of hexahedra."""

import numpy as np
from numpy.typing import NDArray

# The three neighbours of each corner, right-handed, in VTK's numbering.
_NEIGHBOURS = np.array([[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]])


def scaled_jacobian(vertices: NDArray[np.float64], hexahedra: NDArray[np.int64]) -> NDArray[np.float64]:
    """Smallest scaled Jacobian over the corners of each hexahedron: 1 for a box, negative when turned inside out.

    Knupp, "Achieving finite element mesh quality via optimization of the Jacobian matrix norm and associated
    quantities", Int. J. Numer. Meth. Engng 48 (2000) 1165-1185: determinant of the corner's unit edge vectors.

    vertices: (n_vertices, 3), hexahedra: (n, 8) in VTK order; returns: (n,)
    """
    corners = vertices[hexahedra]
    edges = corners[:, _NEIGHBOURS] - corners[:, :, None, :]
    units = edges / np.linalg.norm(edges, axis=-1, keepdims=True)
    smallest: NDArray[np.float64] = np.linalg.det(units).min(axis=1)
    return smallest
