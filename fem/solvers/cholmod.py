"""CHOLMOD through scikit-sparse: the open choice, where it is installed (it needs SuiteSparse and a compiler)."""

from collections.abc import Callable
from types import ModuleType

from scipy import sparse

from updamp.fem.solvers.linear_solver import Floats, SolverFailedError, SolverMissingError

Solve = Callable[[Floats], Floats]


def cholmod(matrix: sparse.bsr_array, near_null_space: Floats) -> "CholmodFactorisation":  # noqa: ARG001
    """See LinearSolver. Supernodal Cholesky factorisation with METIS ordering."""
    try:
        import sksparse.cholmod as library
    except ImportError as missing:
        raise SolverMissingError(
            f"the solver 'cholmod' is not available ({missing}); install SuiteSparse (Debian: apt install "
            "libsuitesparse-dev) and then: pip install scikit-sparse==0.4.16 (0.5 needs SuiteSparse 7); "
            "or choose reduction.solver = 'pardiso' or 'amg'"
        ) from missing
    # Version 0.5 renamed the functions: `cholesky` now returns the factor as a sparse matrix, `cho_factor` an object.
    factorise = _factorise_new if hasattr(library, "cho_factor") else _factorise_old
    try:
        return CholmodFactorisation(factorise(library, matrix.tocsc()))
    except library.CholmodError as failure:
        raise SolverFailedError(
            f"CHOLMOD: {failure}; check that the component is clamped and its material sound, or use the solver 'amg' "
            "where memory is short"
        ) from failure


def _factorise_old(library: ModuleType, matrix: sparse.csc_array) -> Solve:
    # scikit-sparse 0.4 knows scipy's matrices only, not its arrays.
    return library.cholesky(sparse.csc_matrix(matrix), mode="supernodal", ordering_method="metis").solve_A


def _factorise_new(library: ModuleType, matrix: sparse.csc_array) -> Solve:
    return library.cho_factor(matrix, lower=True, order="metis", supernodal_mode="supernodal").solve


class CholmodFactorisation:
    """See Factorisation."""

    def __init__(self, solve: Solve) -> None:
        self._solve: Solve | None = solve

    def solve(self, rhs: Floats) -> Floats:
        if self._solve is None:
            raise SolverFailedError("CHOLMOD: the factorisation was closed; factorise again")
        return self._solve(rhs)

    def close(self) -> None:
        self._solve = None
