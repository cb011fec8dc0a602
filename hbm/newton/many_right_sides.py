"""Solve with the Jacobian J = I + G T for many right-hand sides at once.

The factors are shared by all of them. The given Jacobian may be that of the last Newton step, one step before the
solution; so what is left is measured with the tangents at the solution itself and solved for again until it is small.
"""

from functools import singledispatch
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton.active_forces import DirectForces, KrylovForces, ModalForces
from updamp.hbm.newton.jacobian import Jacobian
from updamp.hbm.newton.tangent import active_rows
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Departure, NonlinearSystem

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
    tolerance: of what is left of each right-hand side, over its size
    raises: RuntimeError where corrections do not bring it there
    """
    system, rows = jacobian.receptance.system, active_rows(jacobian.receptance.system, departure)
    size = np.maximum(np.abs(right).max(axis=(0, 1)), np.finfo(float).tiny)
    solution, left = np.zeros_like(right), right
    for _ in range(CORRECTIONS):
        solution = solution + _once(jacobian, left)
        forces = apply_tangents(system, departure, solution)
        left = right - solution - _apply_receptance(jacobian.receptance, forces[rows], rows)
        share = float((np.abs(left).max(axis=(0, 1)) / size).max())
        if share < tolerance:
            return solution, forces
    raise RuntimeError(
        f"the sensitivities' equations keep a residual of {share:.1e} after {CORRECTIONS} corrections: the point is "
        "a fold or the Jacobian is not that of this solution; solve the point again with a tighter tolerance"
    )


def apply_tangents(system: NonlinearSystem, departure: Departure, x: Floats) -> Floats:
    """T x: (n_relative, n_coefficients, n_right) -> same"""
    forces = np.empty_like(x)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        n, d, c = tangent.shape[:3]
        product = tangent.reshape(n, d * c, d * c) @ x[group.rows].reshape(n, d * c, -1)
        forces[group.rows] = product.reshape(n, d, c, -1)
    return forces


def _apply_receptance(receptance: Receptance, forces: Floats, rows: Integers) -> Floats:
    """G forces: from those on `rows`, (len(rows), n_coefficients, n_right), to all relative rows"""
    stuck, (n, c, p) = receptance.system.stuck, forces.shape
    given = forces.reshape(n, c * p)
    generalised = (stuck.phi[rows].T @ given).reshape(-1, c, p)
    modal = receptance.through_modes(generalised)
    moved = stuck.phi[: stuck.n_relative] @ modal.reshape(-1, c * p)
    if stuck.has_residual:
        moved += stuck.residual[: stuck.n_relative, rows] @ given
    return moved.reshape(-1, c, p)


def _once(jacobian: Jacobian, right: Floats) -> Floats:
    if jacobian.forces is None:
        return right
    b = apply_tangents(jacobian.receptance.system, jacobian.departure, right)
    return right - _moved_by_forces(jacobian.forces, jacobian, b)


@singledispatch
def _moved_by_forces(forces: Any, jacobian: Jacobian, b: Floats) -> Floats:
    """G y of the forces y + T G y = b: (n_relative, n_coefficients, n_right) -> same

    One after the other for a solver not known here.
    """
    y = np.stack([forces(b[..., i])[jacobian.rows] for i in range(b.shape[2])], axis=2)
    return _apply_receptance(jacobian.receptance, y, jacobian.rows)


@_moved_by_forces.register
def _(forces: DirectForces, jacobian: Jacobian, b: Floats) -> Floats:
    return _apply_receptance(jacobian.receptance, forces.solve(b[jacobian.rows]), jacobian.rows)


@_moved_by_forces.register
def _(forces: ModalForces, jacobian: Jacobian, b: Floats) -> Floats:  # noqa: ARG001 - others need it
    """The modes' motion is what the equations in the modes are solved for."""
    phi, (n, c, p) = forces._phi, b.shape
    loads = (phi.T @ b.reshape(n, c * p)).reshape(-1, p)
    modal = scipy.linalg.lu_solve(forces._factors, loads, check_finite=False)
    return np.asarray(phi @ modal.reshape(phi.shape[1], c * p)).reshape(b.shape)


@_moved_by_forces.register
def _(forces: KrylovForces, jacobian: Jacobian, b: Floats) -> Floats:
    """Directly: from about ten right-hand sides on, one factorisation costs less than as many Krylov spaces, and a
    space shared by all (block GMRES) was not smaller by enough to pay for its orthogonalisation.
    """
    return _moved_by_forces(forces._direct, jacobian, b)
