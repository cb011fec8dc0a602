"""Hexahedra with mid-edge nodes: the 20-node serendipity mesh of one component."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.io.meshio import INV_HEX_MAPPING

from updamp.geometry.rig_mesh import ComponentMesh

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
EdgeLookup = Callable[[Integers], Integers]


@dataclass(frozen=True, eq=False)
class QuadraticMesh:
    """Nodes are the mesh's vertices (same numbers), then the middles of its edges.

    Degrees of freedom are interleaved: 3 * node + component.

    nodes: (n_nodes, 3) [m]
    connectivity: (n_elements, 20) node numbers in the order of skfem.ElementHexS2
    faces: named groups of facets, each (n_faces, 8) node numbers in the order of skfem.ElementQuadS2
    points: named nodes
    """

    name: str
    nodes: Floats
    connectivity: Integers
    faces: Mapping[str, Integers]
    points: Mapping[str, int]

    @property
    def n_dofs(self) -> int:
        return 3 * len(self.nodes)


def quadratic_mesh(component: ComponentMesh) -> QuadraticMesh:
    """Add the mid-edge nodes.

    raises: ValueError where a vertex belongs to no hexahedron (its stiffness would be singular), or a
        face's edge is not an edge of the hexahedra
    """
    n_vertices = len(component.vertices)
    unused = np.setdiff1d(np.arange(n_vertices), component.hexahedra)
    if len(unused):
        raise ValueError(
            f"mesh of the {component.name}: vertex {unused[0]} (and {len(unused) - 1} more) belongs to no hexahedron; "
            "remove vertices that no element uses"
        )
    hexahedra = component.hexahedra[:, INV_HEX_MAPPING[:8]]
    mesh = skfem.MeshHex(
        np.ascontiguousarray(component.vertices.T), np.ascontiguousarray(hexahedra.T.astype(np.int32)), validate=False
    )
    dofs = skfem.Dofs(mesh, skfem.ElementHexS2())
    middles = component.vertices[mesh.edges].mean(axis=0)
    edge_node = _edge_lookup(mesh.edges.astype(np.int64), n_vertices)
    return QuadraticMesh(
        component.name,
        np.vstack([component.vertices, middles]),
        dofs.element_dofs.T.astype(np.int64),
        {name: _with_mid_edges(quads, edge_node, name) for name, quads in component.faces.items()},
        dict(component.points),
    )


def _edge_lookup(edges: Integers, n_vertices: int) -> EdgeLookup:
    """Function from vertex pairs (n, 2) to their mid-edge nodes (n,), -1 where there is no such edge."""
    keys = edges[0] * n_vertices + edges[1]
    order = np.argsort(keys)

    def lookup(pairs: Integers) -> Integers:
        low, high = np.sort(pairs, axis=1).T
        wanted = low * n_vertices + high
        slot = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)]
        return np.where(keys[slot] == wanted, n_vertices + slot, -1)

    return lookup


def _with_mid_edges(quads: Integers, edge_node: EdgeLookup, name: str) -> Integers:
    """(n, 4) vertices in cyclic order -> (n, 8): the vertices, then the middles of edges 01, 12, 23, 30."""
    quads = np.asarray(quads, dtype=np.int64).reshape(-1, 4)
    middles = np.stack([edge_node(quads[:, [k, (k + 1) % 4]]) for k in range(4)], axis=1)
    if (middles < 0).any():
        raise ValueError(
            f"face group '{name}': quadrilateral {quads[(middles < 0).any(axis=1)][0]} is not a side of any "
            "hexahedron; give its vertices in cyclic order"
        )
    return np.hstack([quads, middles])
