"""What the mesh stage hands on: hexahedra, named groups and contact elements."""

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
