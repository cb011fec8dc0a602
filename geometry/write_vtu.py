"""Meshes for ParaView."""

from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from updamp.geometry.rig_mesh import ComponentMesh, RigMesh, mirrored_mesh

# Ends of the twelve edges in the order of VTK's quadratic hexahedron.
_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int64
)


def write_vtu(rig_mesh: RigMesh, folder: Path) -> tuple[Path, ...]:
    """Write blade_right.vtu, blade_left.vtu, damper.vtu (20-node hexahedra) and contacts.vtu (triangles).

    The triangles carry `area` [m^2] and `face` (0 left, 1 right). The folder is made when it is missing.

    returns: the files
    """
    folder.mkdir(parents=True, exist_ok=True)
    meshes = {
        "blade_right": _quadratic(rig_mesh.blade),
        "blade_left": _quadratic(mirrored_mesh(rig_mesh.blade)),
        "damper": _quadratic(rig_mesh.damper),
        "contacts": _triangles(rig_mesh),
    }
    files = tuple(folder / f"{name}.vtu" for name in meshes)
    for file, mesh in zip(files, meshes.values(), strict=True):
        mesh.write(file)
    return files


def with_mid_edge_nodes(component: ComponentMesh) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Nodes (n_nodes, 3) [m], the vertices first, and 20-node hexahedra (n_elements, 20) in VTK order."""
    edges = np.sort(component.hexahedra[:, _EDGES], axis=-1).reshape(-1, 2)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    middles = component.vertices[unique].mean(axis=1)
    numbers = len(component.vertices) + number.reshape(-1, len(_EDGES))
    return np.concatenate([component.vertices, middles]), np.concatenate([component.hexahedra, numbers], axis=1)


def _quadratic(component: ComponentMesh) -> meshio.Mesh:
    nodes, hexahedra = with_mid_edge_nodes(component)
    return meshio.Mesh(nodes, [("hexahedron20", hexahedra)])


def _triangles(rig_mesh: RigMesh) -> meshio.Mesh:
    contacts = rig_mesh.contacts
    cells = np.arange(3 * len(contacts)).reshape(-1, 3)
    return meshio.Mesh(
        contacts.triangle.reshape(-1, 3),
        [("triangle", cells)],
        cell_data={"area": [contacts.area], "face": [contacts.face]},
    )
