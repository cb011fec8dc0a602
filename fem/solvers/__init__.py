"""Solvers by the name a rig file calls them."""

from updamp.fem.solvers.amg import amg
from updamp.fem.solvers.cholmod import cholmod
from updamp.fem.solvers.linear_solver import Factorisation, LinearSolver, SolverFailedError, SolverMissingError
from updamp.fem.solvers.pardiso import pardiso

SOLVERS: dict[str, LinearSolver] = {"pardiso": pardiso, "cholmod": cholmod, "amg": amg}

__all__ = ["SOLVERS", "Factorisation", "LinearSolver", "SolverFailedError", "SolverMissingError", "solver_named"]


def solver_named(name: str) -> LinearSolver:
    """raises: ValueError for an unknown name, listing the known ones"""
    if name not in SOLVERS:
        raise ValueError(f"reduction.solver = '{name}' is unknown; choose one of {', '.join(SOLVERS)}")
    return SOLVERS[name]
