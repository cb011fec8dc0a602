"""What the mesh stage hands on: hexahedra, named groups and contact elements; their quality, and their mirror image."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.geometry.contact_elements import ContactElements

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ComponentMesh:
    """Hexahedra of one component. Edges are straight; mid-edge nodes are added by the finite elements.

    vertices: (n_vertices, 3) [m]
    hexahedra: (n_elements, 8) vertex numbers in meshio/VTK order
    faces: named groups of quadrilaterals, each (n_faces, 4) vertex numbers
    points: named vertices
    """

    name: str
    vertices: Floats
    hexahedra: Integers
    faces: Mapping[str, Integers]
    points: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class RigMesh:
    """The right-hand blade (the left one is its mirror image x -> -x), the damper, and the contacts.

    Axes: x across the blades (bending direction), y up (root at 0), z along the damper, origin midway.
    blade faces: "root", "contact"; points: "excitation", "tip", "platform"
    damper faces: "contact_left", "contact_right", "end_back" (z < 0), "end_front" (z > 0);
    points: "corner_left", "corner_right" (bottom corners at mid-length)
    """

    blade: ComponentMesh
    damper: ComponentMesh
    contacts: ContactElements
    min_scaled_jacobian: float

    @property
    def blade_elements(self) -> int:
        """Hexahedra of both blades."""
        return 2 * len(self.blade.hexahedra)

    @property
    def damper_elements(self) -> int:
        return len(self.damper.hexahedra)


class GeometryError(ValueError):
    """Of a rig that cannot be meshed well: names the key of the rig file, its value and what would be allowed."""

    def __init__(self, key: str, value: str, allowed: str) -> None:
        super().__init__(f"{key} = {value}: {allowed}")
        self.key = key
        self.value = value
        self.allowed = allowed


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


_HEXAHEDRON = [0, 3, 2, 1, 4, 7, 6, 5]
_QUADRILATERAL = [0, 3, 2, 1]


def mirrored_mesh(component: ComponentMesh) -> ComponentMesh:
    """Mirror image x -> -x. Vertices keep their numbers; cells are renumbered so that volumes stay positive."""
    return ComponentMesh(
        name=component.name,
        vertices=component.vertices * np.array([-1.0, 1.0, 1.0]),
        hexahedra=component.hexahedra[:, _HEXAHEDRON],
        faces={name: quads[:, _QUADRILATERAL] for name, quads in component.faces.items()},
        points=component.points,
    )
