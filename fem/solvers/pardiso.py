"""MKL PARDISO through pypardiso: the default. Installs by pip alone; MKL is free of charge but not open source.

pypardiso's own `solve` compares and copies the whole matrix at each call and leaves PARDISO's defaults on, which for
positive definite matrices cost twice the factor and seven times the solve. So the library it loaded is called directly.

The same system has the same solution to the last digit on one machine, whatever else is loaded. Without MKL's
conditional numerical reproducibility its last digits depend on the OpenMP library that it finds in the process (GNU's
once gmsh is loaded, else Intel's), and with threads on chance. The number of threads enters in one place: where large
systems are solved for many right-hand sides at once, one thread has other last digits than several.
"""

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from updamp.fem.solvers.linear_solver import Floats, SolverFailedError, SolverMissingError

_ANALYSE_AND_FACTORISE, _SOLVE, _RELEASE = 12, 33, -1
_POSITIVE_DEFINITE = 2
# Unknowns from which on MKL's threads help: with fewer a solve takes milliseconds, and they wait for each other (13,554
# on two busy cores: 24 modes in 1.5 s by one thread, 7 s by two; 87,909: 13 and 19 s).
_ENOUGH_FOR_THREADS = 50_000
# oneMKL's developer reference, "Conditional Numerical Reproducibility Control" and "pardiso iparm parameter": the best
# branch of code for the machine, fixed; a dissection that is not parallel, which would rule it out; and the work cut
# into so many parts, whatever the number of threads that share them: four, for up to four threads.
_FIXED_BRANCH, _DISSECTION, _PARTS = 2, 2, 4
_MEANING = {
    -2: "not enough memory; use the solver 'amg' or a coarser mesh",
    -4: "the matrix is not positive definite; check that the component is clamped and its material sound",
    -8: "32-bit integer overflow; use the solver 'cholmod' or 'amg'",
}


def pardiso(matrix: sparse.bsr_array, near_null_space: Floats) -> "PardisoFactorisation":  # noqa: ARG001
    """See LinearSolver. Cholesky factorisation of the upper triangle, without scaling, matching or refinement."""
    try:
        import pypardiso
    except ImportError as missing:
        raise SolverMissingError(
            f"the solver 'pardiso' is not available ({missing}); install it with: pip install pypardiso "
            "(or choose reduction.solver = 'cholmod' or 'amg')"
        ) from missing
    return PardisoFactorisation(pypardiso.ps.libmkl, matrix)


class PardisoFactorisation:
    """See Factorisation."""

    def __init__(self, library: ctypes.CDLL, matrix: sparse.bsr_array) -> None:
        library.MKL_CBWR_Set(_FIXED_BRANCH)  # refused, to no harm, once it is set
        self._routine = library.pardiso
        self._set_threads = library.MKL_Set_Num_Threads_Local  # 0: as they were stated for all
        self._handle = np.zeros(64, dtype=np.int64)
        self._parameters = np.zeros(64, dtype=np.int32)
        self._parameters[0] = 1  # take the values given here
        self._parameters[1], self._parameters[33] = _DISSECTION, _PARTS
        self._permutation = np.zeros(1, dtype=np.int32)
        self._indptr, self._indices, self._data = upper_triangle(matrix, first=1)
        self._size = matrix.shape[0]
        self._open = True
        self._call(_ANALYSE_AND_FACTORISE, np.zeros(1), np.zeros(1), 1)

    def solve(self, rhs: Floats) -> Floats:
        if not self._open:
            raise SolverFailedError("PARDISO: the factorisation was closed; factorise again")
        rhs = np.asfortranarray(rhs, dtype=np.float64)
        solution = np.empty_like(rhs, order="F")
        self._call(_SOLVE, rhs, solution, 1 if rhs.ndim == 1 else rhs.shape[1])
        return solution

    def close(self) -> None:
        if self._open:
            self._call(_RELEASE, np.zeros(1), np.zeros(1), 1)
            self._open = False
            self._indptr = self._indices = np.zeros(0, dtype=np.int32)
            self._data = np.zeros(0)

    def __del__(self) -> None:
        self.close()

    def _call(self, phase: int, rhs: Floats, solution: Floats, n_rhs: int) -> None:
        def number(value: int) -> Any:
            return ctypes.byref(ctypes.c_int32(value))

        def integers(array: NDArray[np.int32]) -> Any:
            return array.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))

        error = ctypes.c_int32(0)
        before = self._set_threads(1) if self._size < _ENOUGH_FOR_THREADS else 0
        self._routine(
            self._handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            number(1),
            number(1),
            number(_POSITIVE_DEFINITE),
            number(phase),
            number(self._size),
            self._data.ctypes.data,
            integers(self._indptr),
            integers(self._indices),
            integers(self._permutation),
            number(n_rhs),
            integers(self._parameters),
            number(0),
            rhs.ctypes.data,
            solution.ctypes.data,
            ctypes.byref(error),
        )
        self._set_threads(before)
        if error.value:
            meaning = _MEANING.get(error.value, "see the error codes in PARDISO's documentation")
            raise SolverFailedError(f"PARDISO stopped with error {error.value}: {meaning}")


def upper_triangle(matrix: sparse.bsr_array, first: int) -> tuple[NDArray[np.int32], NDArray[np.int32], Floats]:
    """Compressed rows (indptr, indices, data) of the upper triangle, numbered from `first`.

    Whole blocks below the diagonal go before the blocks are spelt out: scipy's triu would need three times the memory.
    """
    block_rows = np.repeat(np.arange(len(matrix.indptr) - 1, dtype=np.int32), np.diff(matrix.indptr))
    upper = matrix.indices >= block_rows
    counts = np.bincount(block_rows[upper], minlength=len(matrix.indptr) - 1)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    rows = sparse.bsr_array((matrix.data[upper], matrix.indices[upper], indptr), shape=matrix.shape).tocsr()
    rows.sort_indices()
    keep = rows.indices >= np.repeat(np.arange(rows.shape[0], dtype=np.int32), np.diff(rows.indptr))
    counts = np.add.reduceat(keep, rows.indptr[:-1], dtype=np.int32)
    indptr = (np.concatenate([[0], np.cumsum(counts)]) + first).astype(np.int32)
    return indptr, (rows.indices[keep] + np.int32(first)).astype(np.int32), rows.data[keep]
