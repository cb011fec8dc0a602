"""The largest eigenvalues of a symmetric operator by block Lanczos, for operators that are cheap a block at a time.

A triangular solve reads the whole factor, so eight right-hand sides cost hardly more than two. Every new block is made
orthogonal to all before it, twice (Grimes, Lewis and Simon 1994, SIAM J. Matrix Anal. Appl. 15, have the method and
cheaper ways to keep the blocks orthogonal, which a hundred vectors do not need).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BlockLanczosOptions:
    """block: vectors at a time; tolerance: of the residuals, in the norm of the mass, relative to the eigenvalues
    rank: directions of a block that are smaller than this share of the largest are left out: nothing new is in them
    most_blocks: after which it ends with what there is
    """

    block: int = 8
    tolerance: float = 1e-10
    rank: float = 1e-10
    most_blocks: int = 60


def largest_eigenvectors(
    operator: Callable[[Floats], Floats],
    mass: sparse.csr_array,
    start: Floats,
    number: int,
    options: BlockLanczosOptions | None = None,
) -> Floats:
    """(n_dofs, number) eigenvectors of `operator(mass @ x)`, orthonormal in the mass, largest eigenvalue first.

    operator: (n_dofs, m) -> (n_dofs, m), symmetric; start: (n_dofs, block)
    What is not found to the tolerance is handed out as it is: the caller measures the residual that it needs.
    """
    options = options or BlockLanczosOptions()
    block, _, loads = _orthonormal(start, mass, options.rank)
    blocks: list[Floats] = []
    columns: list[Floats] = []  # of the projected operator, on and above its diagonal
    while True:
        blocks.append(block)
        image = operator(loads)
        image, coefficients = _orthogonal(image, blocks, mass)
        columns.append(coefficients)
        values, vectors = _projected(columns)
        block, below, loads = _orthonormal(image, mass, options.rank)
        chosen = vectors[:, ::-1][:, :number]
        residuals = np.linalg.norm(below @ chosen[-columns[-1].shape[1] :], axis=0)
        found = len(values) >= number and (residuals <= options.tolerance * values[::-1][:number]).all()
        if found or not block.shape[1] or len(blocks) == options.most_blocks:
            return np.asarray(np.hstack(blocks) @ chosen)


def _orthogonal(image: Floats, blocks: list[Floats], mass: sparse.csr_array) -> tuple[Floats, Floats]:
    """What of the image is orthogonal to all blocks, and its components along them (n_vectors, m)."""
    coefficients = np.zeros((sum(one.shape[1] for one in blocks), image.shape[1]))
    for _ in range(2):
        weighted = mass @ image
        along = [one.T @ weighted for one in blocks]
        image = image - sum(one @ part for one, part in zip(blocks, along, strict=True))
        coefficients += np.vstack(along)
    return image, coefficients


def _orthonormal(image: Floats, mass: sparse.csr_array, rank: float) -> tuple[Floats, Floats, Floats]:
    """Vectors (n_dofs, r), orthonormal in the mass, the factor R (r, m) with image = vectors R, and mass @ vectors."""
    vectors, factor = image, np.eye(image.shape[1])
    largest = None
    for _ in range(2):
        weighted = mass @ vectors
        squares, axes = linalg.eigh(vectors.T @ weighted)
        largest = squares[-1] if largest is None else largest
        kept = squares > max(rank**2 * largest, np.finfo(float).tiny)
        sizes, axes = np.sqrt(squares[kept]), axes[:, kept]
        vectors, factor = vectors @ (axes / sizes), (sizes[:, None] * axes.T) @ factor
        weighted = weighted @ (axes / sizes)
    return vectors, factor, weighted


def _projected(columns: list[Floats]) -> tuple[Floats, Floats]:
    """Eigenvalues, rising, and eigenvectors of the operator on the space so far."""
    matrix = np.zeros((len(columns[-1]), len(columns[-1])))
    first = 0
    for column in columns:
        matrix[: len(column), first : first + column.shape[1]] = column
        first += column.shape[1]
    values, vectors = linalg.eigh(matrix, lower=False)
    return values, vectors
