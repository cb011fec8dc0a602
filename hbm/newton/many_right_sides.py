"""Solve with the Jacobian J = I + G T for many right-hand sides at once.

As in jacobian.py, x = r - G y with y + T G y = T r on the active rows. The factors are shared by all right-hand sides.
They may be those of the last Newton step, one step before the solution; so what is left is measured with the tangents
at the solution itself and solved for again until it is small.
"""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.active_operator import ActiveOperator
from updamp.hbm.newton.jacobian import ForceSolver, Jacobian
from updamp.hbm.newton.tangent import active_rows, apply_tangent
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Departure

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

CORRECTIONS = 4


def solve_many(jacobian: Jacobian, departure: Departure, right: Floats, tolerance: float = 1e-8) -> Floats:
    """As `solve_with_forces`, without the forces."""
    return solve_with_forces(jacobian, departure, right, tolerance)[0]


def solve_with_forces(
    jacobian: Jacobian, departure: Departure, right: Floats, tolerance: float = 1e-8
) -> tuple[Floats, Floats]:
    """x = J^-1 right for the tangents T of `departure`, and T x: (n_relative, n_coefficients, n_right) -> same, each

    jacobian: the same or one nearby
    tolerance: of what is left of the forces of each right-hand side, over their size
    raises: RuntimeError where corrections do not bring it there
    """
    system = jacobian.receptance.system
    rows = np.union1d(jacobian.rows, active_rows(system, departure))
    forces = np.zeros_like(right)
    if jacobian.forces is None or not len(rows):
        return right, forces
    b = apply_tangent(system, departure, right)[rows]
    forces[rows] = y = _active_forces(jacobian, jacobian.forces, departure, b, rows, tolerance)
    return right - _moved(jacobian.receptance, y, rows), forces


def _active_forces(
    jacobian: Jacobian, solver: ForceSolver, departure: Departure, b: Floats, rows: Integers, tolerance: float
) -> Floats:
    """y of y + T G y = b, all on `rows`, (len(rows), n_coefficients, n_right), among them those of the Jacobian"""
    operator, known = ActiveOperator(jacobian.receptance, departure, rows), np.searchsorted(rows, jacobian.rows)
    size = np.maximum(np.abs(b).max(axis=(0, 1)), np.finfo(float).tiny)
    y, left = np.zeros_like(b), b
    for _ in range(CORRECTIONS):
        change = left.copy()
        change[known] = solver.solve(left[known])
        y += change
        left = b - operator.of_many(y)
        share = float((np.abs(left).max(axis=(0, 1)) / size).max())
        if share < tolerance:
            return y
    raise RuntimeError(
        f"the sensitivities' equations keep a residual of {share:.1e} after {CORRECTIONS} corrections: the point is "
        "a fold or the Jacobian is not that of this solution; solve the point again with a tighter tolerance"
    )


def _moved(receptance: Receptance, forces: Floats, rows: Integers) -> Floats:
    """G forces: from those on `rows`, (len(rows), n_coefficients, n_right), to all relative rows"""
    stuck, (n, c, p) = receptance.system.stuck, forces.shape
    given = forces.reshape(n, c * p)
    modal = receptance.through_modes((stuck.phi[rows].T @ given).reshape(-1, c, p))
    moved = stuck.phi[: stuck.n_relative] @ modal.reshape(-1, c * p)
    if stuck.has_residual:
        moved += stuck.residual[: stuck.n_relative, rows] @ given
    return moved.reshape(-1, c, p)
