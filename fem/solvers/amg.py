"""Conjugate gradients with pyamg's smoothed aggregation: the low-memory way, and slower for many right-hand sides."""

import numpy as np
import pyamg
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from updamp.fem.solvers.linear_solver import Floats, SolverFailedError

# Of the residual. Shift-invert modes and residual flexibilities inherit this accuracy.
RELATIVE_TOLERANCE = 1e-12
MAX_ITERATIONS = 2000
# Quadratic elements couple each node to some eighty others; aggregating over all of them coarsens by forty at once.
# On 106,000 unknowns of nearly cubic elements 0.08 took 60 iterations against 84 for pyamg's default.
STRENGTH_THRESHOLD = 0.08


def amg(matrix: sparse.bsr_array, near_null_space: Floats) -> "AmgPreparation":
    """See LinearSolver. Aggregation with the rigid-body modes as near null space (Vanek, Mandel, Brezina 1996)."""
    # pyamg knows scipy's matrices only, not its arrays.
    hierarchy = pyamg.smoothed_aggregation_solver(
        sparse.bsr_matrix(matrix),
        B=np.ascontiguousarray(near_null_space),
        symmetry="symmetric",
        strength=("symmetric", {"theta": STRENGTH_THRESHOLD}),
        smooth=("energy", {"degree": 2, "maxiter": 4}),
        max_coarse=500,
    )
    return AmgPreparation(matrix, hierarchy.aspreconditioner(cycle="V"))


class AmgPreparation:
    """See Factorisation; nothing is factorised but the coarsest level."""

    def __init__(self, matrix: sparse.bsr_array, preconditioner: LinearOperator) -> None:
        self._matrix: sparse.bsr_array | None = matrix
        self._preconditioner: LinearOperator | None = preconditioner

    def solve(self, rhs: Floats) -> Floats:
        if rhs.ndim == 1:
            return self._solve_one(rhs)
        return np.stack([self._solve_one(column) for column in rhs.T], axis=1)

    def close(self) -> None:
        self._matrix = self._preconditioner = None

    def _solve_one(self, rhs: Floats) -> Floats:
        if self._matrix is None:
            raise SolverFailedError("AMG: the hierarchy was closed; prepare it again")
        solution, status = cg(
            self._matrix, rhs, rtol=RELATIVE_TOLERANCE, maxiter=MAX_ITERATIONS, M=self._preconditioner
        )
        if status:
            reached = np.linalg.norm(rhs - self._matrix @ solution) / np.linalg.norm(rhs)
            raise SolverFailedError(
                f"AMG: conjugate gradients reached a relative residual of {reached:.2e} in {MAX_ITERATIONS} steps, "
                f"{RELATIVE_TOLERANCE:.0e} is asked for; use a direct solver ('pardiso', 'cholmod') or a mesh with "
                "less elongated elements"
            )
        return solution
