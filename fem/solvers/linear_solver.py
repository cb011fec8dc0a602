"""What the finite elements ask of a solver of large symmetric positive definite systems."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Floats = NDArray[np.float64]


class SolverMissingError(ImportError):
    """The chosen solver is not installed; the message says how to get it."""


class SolverFailedError(RuntimeError):
    """The chosen solver met a matrix it cannot handle; the message says what to try."""


class Factorisation(Protocol):
    """A matrix made ready for many right-hand sides. Holds memory outside Python until `close`."""

    def solve(self, rhs: Floats) -> Floats:
        """rhs: (n,) or (n, m) -> solution of the same shape. raises: SolverFailedError"""
        ...

    def close(self) -> None:
        """Give the memory back; `solve` must not be called after."""
        ...


class LinearSolver(Protocol):
    """Factorises (or prepares) a symmetric positive definite matrix in 3 x 3 blocks.

    matrix: (n, n) [N/m]
    near_null_space: (n, up to 6) fields that cost (almost) no energy, rigid-body motion, those of half of a component
        where it is one; direct solvers ignore it
    raises: SolverMissingError, SolverFailedError
    """

    def __call__(self, matrix: sparse.bsr_array, near_null_space: Floats) -> Factorisation: ...
