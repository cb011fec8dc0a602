"""A component that is its own mirror image across its width, as two models of half the size.

Its motions are alike on both sides of the middle plane or opposite, and neither kind loads the other: each has the
stiffness of one half of the mesh, with the conditions of symmetry or of antisymmetry on the plane. Half of the
arithmetic of a factorisation, four fifths of its memory, and each kind's modes found by themselves.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from updamp.fem.assembly import SHAPE_TOLERANCE, SystemMatrices, principal_blocks

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Field = TypeVar("Field", Floats, sparse.csc_array)

ACROSS = np.array([1.0, 1.0, -1.0])  # what a mirror image z -> -z does to a displacement
SEED = 20261127


@dataclass(frozen=True, eq=False)
class Subspace:
    """Motions of a component that its stiffness and its mass do not couple to its other motions.

    stiffness: (n, n) basis^T K basis, in 3 x 3 blocks [N/m]
    basis: (n_dofs, n) orthonormal columns; None where it is all motions
    """

    stiffness: sparse.bsr_array
    basis: sparse.csr_array | None = None

    def within(self, field: Field) -> Field:
        """What of a field or load (n_dofs, ...) belongs to it, (n, ...)."""
        return field if self.basis is None else self.basis.T @ field

    def outside(self, part: Floats) -> Floats:
        """(n, ...) as a field or load of the component, (n_dofs, ...)."""
        return part if self.basis is None else self.basis @ part


def half_models(nodes: Floats, matrices: SystemMatrices) -> tuple[Subspace, ...]:
    """Motions alike on both sides, and opposite ones; all motions in one where the component has no such image, or an
    element on both sides of the plane.

    nodes: (n_free, 3) [m], of the free nodes
    """
    image = mirror_image(nodes)
    if image is None or not _is_mirrored(matrices, image):
        return (Subspace(matrices.stiffness),)
    upper = nodes[:, 2] >= nodes[image, 2]
    on_plane = image == np.arange(len(image))
    if _coupled(matrices.stiffness, upper & ~on_plane, ~upper):
        return (Subspace(matrices.stiffness),)
    return tuple(_half(matrices.stiffness, image, upper, on_plane, sign) for sign in (1.0, -1.0))


def mirror_image(nodes: Floats) -> Integers | None:
    """(n,) the node at each node's image across the middle plane z = constant, to SHAPE_TOLERANCE of the mesh's size.

    nodes: (n, 3). returns: None where some node has none
    """
    lowest, highest = nodes.min(axis=0), nodes.max(axis=0)
    there = nodes * ACROSS + [0.0, 0.0, lowest[2] + highest[2]]
    distance, image = (np.asarray(found) for found in cKDTree(nodes).query(there))
    near = distance.max() <= SHAPE_TOLERANCE * (highest - lowest).max()
    return image if near and np.array_equal(image[image], np.arange(len(image))) else None


def _is_mirrored(matrices: SystemMatrices, image: Integers) -> bool:
    """Whether a motion's mirror image has the mirrored forces; elements between the nodes might differ."""

    def mirrored(field: Floats) -> Floats:
        return (field.reshape(-1, 3)[image] * ACROSS).ravel()

    motion = np.random.default_rng(SEED).standard_normal(matrices.n_dofs)
    for product in (matrices.stiffness.dot, matrices.mass.dot):
        forces = mirrored(product(motion))
        if np.linalg.norm(product(mirrored(motion)) - forces) > SHAPE_TOLERANCE * np.linalg.norm(forces):
            return False
    return True


def _coupled(matrix: sparse.bsr_array, some: NDArray[np.bool_], others: NDArray[np.bool_]) -> bool:
    rows = np.repeat(some, np.diff(matrix.indptr))
    return bool((rows & others[matrix.indices]).any())


def _half(
    stiffness: sparse.bsr_array, image: Integers, upper: NDArray[np.bool_], on_plane: NDArray[np.bool_], sign: float
) -> Subspace:
    """sign: 1 for motions alike on both sides, -1 for opposite ones.

    A column for each direction of the nodes of one side: (u + image of u) / sqrt(2), on the plane u itself. Directions
    that the plane does not allow keep their place in the blocks, as columns of zeros and a stiffness of their own.
    """
    own = np.flatnonzero(upper)
    plane = on_plane[own]
    allowed = np.where(plane[:, None], (1 + sign * ACROSS) / 2, 1.0)
    columns = np.arange(3 * len(own)).reshape(-1, 3)
    first = np.where(plane[:, None], allowed, np.sqrt(0.5)), 3 * own[:, None] + np.arange(3), columns
    second = (
        np.broadcast_to(sign * np.sqrt(0.5) * ACROSS, (int((~plane).sum()), 3)),
        3 * image[own[~plane], None] + np.arange(3),
        columns[~plane],
    )
    values, rows, places = (np.concatenate([a.ravel(), b.ravel()]) for a, b in zip(first, second, strict=True))
    basis = sparse.csr_array((values, (rows, places)), shape=(stiffness.shape[0], columns.size))
    return Subspace(_half_stiffness(principal_blocks(stiffness, upper), plane, allowed), basis)


def _half_stiffness(blocks: sparse.bsr_array, plane: NDArray[np.bool_], allowed: Floats) -> sparse.bsr_array:
    """Between a node beside the plane and one on it both sides count, as sqrt(2) K."""
    rows = np.repeat(np.arange(len(plane)), np.diff(blocks.indptr))
    touched = np.flatnonzero(plane[rows] | plane[blocks.indices])
    row, column = rows[touched], blocks.indices[touched]
    part = blocks.data[touched] * allowed[row][:, :, None] * allowed[column][:, None, :]
    part *= np.where(plane[row] != plane[column], np.sqrt(2), 1.0)[:, None, None]
    diagonal = (row == column)[:, None, None] * np.eye(3)
    blocks.data[touched] = part + diagonal * (1 - allowed[row][:, None, :]) * blocks.data[touched]
    return blocks
