"""The left-hand blade from the right-hand one."""

import numpy as np

from updamp.geometry.rig_mesh import ComponentMesh

_HEXAHEDRON = [0, 3, 2, 1, 4, 7, 6, 5]
_QUADRILATERAL = [0, 3, 2, 1]


def mirrored(component: ComponentMesh) -> ComponentMesh:
    """Mirror image x -> -x. Vertices keep their numbers; cells are renumbered so that volumes stay positive."""
    return ComponentMesh(
        name=component.name,
        vertices=component.vertices * np.array([-1.0, 1.0, 1.0]),
        hexahedra=component.hexahedra[:, _HEXAHEDRON],
        faces={name: quads[:, _QUADRILATERAL] for name, quads in component.faces.items()},
        points=component.points,
    )
