"""Global stiffness and mass: identical elements once, one scalar pattern for all components."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from updamp.fem.element_matrices import ElasticMaterial, element_matrices
from updamp.fem.quadratic_mesh import QuadraticMesh

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Offsets of an element's vertices that agree to this part of the mesh's size are the same shape: far above
# the round-off of extruded meshes (1e-16) and far below any real difference.
SHAPE_TOLERANCE = 1e-10
# Distinct shapes whose matrices are computed in one go: 3 MB a hundred, so that irregular meshes stay cheap too.
SHAPES_AT_ONCE = 512


@dataclass(frozen=True, eq=False)
class SystemMatrices:
    """Stiffness and mass on the nodes that are free to move.

    stiffness: (3 n_free, 3 n_free) symmetric, in 3 x 3 blocks [N/m]
    mass: (3 n_free, 3 n_free) symmetric [kg]
    free_nodes: (n_free,) node numbers of the mesh, ascending
    n_nodes: nodes of the mesh
    """

    stiffness: sparse.bsr_array
    mass: sparse.csr_array
    free_nodes: Integers
    n_nodes: int

    @property
    def n_dofs(self) -> int:
        return self.stiffness.shape[0]

    @property
    def free_dofs(self) -> Integers:
        """(3 n_free,) degrees of freedom of the mesh."""
        return (3 * self.free_nodes[:, None] + np.arange(3)).ravel()

    def on_mesh(self, fields: Floats) -> Floats:
        """Displacement of all nodes, zero where clamped: (3 n_free, m) -> (m, n_nodes, 3)."""
        full = np.zeros((fields.shape[1], self.n_nodes, 3))
        full[:, self.free_nodes] = fields.T.reshape(fields.shape[1], -1, 3)
        return full


def assemble(mesh: QuadraticMesh, material: ElasticMaterial) -> SystemMatrices:
    """Stiffness and mass of the unconstrained component.

    raises: ValueError where an element is turned inside out
    """
    n_nodes = len(mesh.nodes)
    representatives, shape_of = distinct_shapes(mesh)
    indptr, indices, slot = _pattern(mesh.connectivity, n_nodes)
    stiffness_data = np.zeros((len(indices), 3, 3))
    mass_data = np.zeros(len(indices))
    members = np.argsort(shape_of, kind="stable")
    sorted_shapes = shape_of[members]
    for start in range(0, len(representatives), SHAPES_AT_ONCE):
        stop = min(start + SHAPES_AT_ONCE, len(representatives))
        elements = members[slice(*np.searchsorted(sorted_shapes, [start, stop]))]
        corners = mesh.nodes[mesh.connectivity[representatives[start:stop], :8]]
        stiffness, mass = element_matrices(corners, material)
        local = shape_of[elements] - start
        where = slot[elements].ravel()
        mass_data += _gather(where, mass[local], len(indices))
        for i in range(3):
            for j in range(3):
                stiffness_data[:, i, j] += _gather(where, stiffness[..., i, j][local], len(indices))
    return SystemMatrices(
        sparse.bsr_array((stiffness_data, indices, indptr), shape=(3 * n_nodes, 3 * n_nodes)),
        _same_for_each_component(sparse.csr_array((mass_data, indices, indptr), shape=(n_nodes, n_nodes))),
        np.arange(n_nodes),
        n_nodes,
    )


def distinct_shapes(mesh: QuadraticMesh) -> tuple[Integers, Integers]:
    """Elements that are translations of each other share their matrices.

    returns: one element of each shape (n_shapes,), the shape of each element (n_elements,)
    """
    corners = mesh.nodes[mesh.connectivity[:, :8]]
    offsets = (corners[:, 1:] - corners[:, :1]).reshape(len(corners), -1)
    step = SHAPE_TOLERANCE * np.ptp(mesh.nodes, axis=0).max()
    _, representatives, shape_of = np.unique(
        np.round(offsets / step).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    return representatives, shape_of.ravel()


def _pattern(connectivity: Integers, n_nodes: int) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Compressed rows of the scalar problem, and where each entry of each element matrix goes (n, 20, 20)."""
    n_basis = connectivity.shape[1]
    keys = (connectivity[:, :, None] * n_nodes + connectivity[:, None, :]).ravel()
    entries, slot = np.unique(keys, return_inverse=True)
    rows = entries // n_nodes
    indptr = np.searchsorted(rows, np.arange(n_nodes + 1)).astype(np.int32)
    indices = (entries - rows * n_nodes).astype(np.int32)
    return indptr, indices, slot.astype(np.int32).reshape(-1, n_basis, n_basis)


def _gather(where: NDArray[np.int32], values: Floats, length: int) -> Floats:
    return np.bincount(where, weights=values.ravel(), minlength=length).astype(np.float64, copy=False)


def _same_for_each_component(scalar: sparse.csr_array) -> sparse.csr_array:
    return sparse.csr_array(sparse.kron(scalar, sparse.eye_array(3), format="csr"))


def clamp(matrices: SystemMatrices, nodes: Integers) -> SystemMatrices:
    """Hold the given nodes of the mesh; their rows and columns go.

    raises: ValueError where none of them is a free node
    """
    free = ~np.isin(matrices.free_nodes, nodes)
    if free.all():
        raise ValueError("no node to clamp is among the free ones; check the face group that is to be clamped")
    dofs = np.repeat(free, 3)
    return SystemMatrices(
        principal_blocks(matrices.stiffness, free),
        sparse.csr_array(matrices.mass[dofs][:, dofs]),
        matrices.free_nodes[free],
        matrices.n_nodes,
    )


def principal_blocks(matrix: sparse.bsr_array, keep: NDArray[np.bool_]) -> sparse.bsr_array:
    """Rows and columns of the kept nodes; scipy would slice entry by entry, at nine times the cost."""
    number = np.cumsum(keep) - 1
    rows = np.repeat(np.arange(len(keep)), np.diff(matrix.indptr))
    kept = keep[rows] & keep[matrix.indices]
    indptr = np.concatenate([[0], np.cumsum(np.bincount(number[rows[kept]], minlength=number[-1] + 1))])
    size = 3 * int(keep.sum())
    return sparse.bsr_array(
        (matrix.data[kept], number[matrix.indices[kept]].astype(np.int32), indptr.astype(np.int32)), shape=(size, size)
    )
