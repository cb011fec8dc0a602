"""Symmetric eigenproblems whose entries span many orders of magnitude, without loss in the small eigenvalues.

LAPACK's usual solvers err by round-off times the largest eigenvalue. Stuck modes of a rig reach from 0.4 to 200 kHz: of
the lowest one's frequency squared 11 digits are left, and near resonance at a loss factor of 0.1 % 8 digits of the
response. One-sided Jacobi on the Cholesky factor (Demmel and Veselic 1992, SIAM J. Matrix Anal. Appl. 13, 1204-1245)
finds every eigenvalue to round-off times the condition of the matrix scaled to a unit diagonal: 14 digits.
"""

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# dgejsv: accurate whatever the scaling of rows and columns, left vectors, no right ones, all sizes, not transposed
_FULL_ACCURACY, _LEFT, _NONE, _ALL_SIZES, _AS_GIVEN, _UNPERTURBED = 2, 0, 3, 0, 0, 0


def graded_eigh(matrix: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues, rising, and eigenvectors (orthonormal columns) of a symmetric matrix (m, m).

    Where it is not positive definite, as with rigid-body modes, those of LAPACK's usual solver.
    raises: numpy.linalg.LinAlgError where Jacobi's method does not converge
    """
    order = np.argsort(-np.diag(matrix), kind="stable")
    try:
        factor = np.linalg.cholesky(matrix[np.ix_(order, order)])
    except np.linalg.LinAlgError:
        values, vectors = scipy.linalg.eigh(matrix)
        return values, vectors
    sizes, left, _, work, _, status = scipy.linalg.lapack.dgejsv(
        factor, _FULL_ACCURACY, _LEFT, _NONE, _ALL_SIZES, _AS_GIVEN, _UNPERTURBED
    )
    if status != 0:
        raise np.linalg.LinAlgError(f"Jacobi's method for {len(matrix)} modes did not converge (dgejsv: {status})")
    vectors = np.empty_like(left)
    vectors[order] = left
    return (sizes * work[0] / work[1])[::-1] ** 2, vectors[:, ::-1]
