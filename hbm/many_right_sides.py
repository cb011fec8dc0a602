"""Solve with the Jacobian J = I + G T for many right-hand sides at once.

The factors are shared by all of them. The given Jacobian may be that of the last Newton step, one step before the
solution; so what is left is measured with the tangents at the solution itself and solved for again until it is small.
"""

from functools import singledispatch
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.active_forces import DirectForces, KrylovForces, ModalForces
from updamp.hbm.jacobian import Jacobian
from updamp.hbm.structure_response import Loads, respond
from updamp.hbm.system import Departure, NonlinearSystem, Receptance

Floats = NDArray[np.float64]

CORRECTIONS = 4


def solve_many(jacobian: Jacobian, departure: Departure, right: Floats, tolerance: float = 1e-8) -> Floats:
    """J^-1 right for the tangents of `departure`: (n_relative, n_coefficients, n_right) -> same.

    jacobian: the same or one nearby
    tolerance: of what is left of each right-hand side, over its size
    raises: RuntimeError where corrections do not bring it there
    """
    size = np.maximum(np.abs(right).max(axis=(0, 1)), np.finfo(float).tiny)
    solution, left = np.zeros_like(right), right
    for _ in range(CORRECTIONS):
        solution = solution + _once(jacobian, left)
        left = right - apply_jacobian(jacobian.receptance, departure, solution)
        share = float((np.abs(left).max(axis=(0, 1)) / size).max())
        if share < tolerance:
            return solution
    raise RuntimeError(
        f"the sensitivities' equations keep a residual of {share:.1e} after {CORRECTIONS} corrections: the point is "
        "a fold or the Jacobian is not that of this solution; solve the point again with a tighter tolerance"
    )


def apply_jacobian(receptance: Receptance, departure: Departure, x: Floats) -> Floats:
    return x + _apply_receptance(receptance, apply_tangents(receptance.system, departure, x))


def apply_tangents(system: NonlinearSystem, departure: Departure, x: Floats) -> Floats:
    """T x: (n_relative, n_coefficients, n_right) -> same"""
    forces = np.empty_like(x)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        n, d, c = tangent.shape[:3]
        product = tangent.reshape(n, d * c, d * c) @ x[group.rows].reshape(n, d * c, -1)
        forces[group.rows] = product.reshape(n, d, c, -1)
    return forces


def _apply_receptance(receptance: Receptance, forces: Floats) -> Floats:
    """G forces between the relative rows"""
    loads = Loads.none(receptance, forces.shape[2])
    loads.forces[: len(forces)] = forces
    return respond(receptance, loads).at(slice(len(forces)))


def _once(jacobian: Jacobian, right: Floats) -> Floats:
    if jacobian.forces is None:
        return right
    b = apply_tangents(jacobian.receptance.system, jacobian.departure, right)
    return right - _apply_receptance(jacobian.receptance, _solve_forces(jacobian.forces, jacobian, b))


@singledispatch
def _solve_forces(forces: Any, jacobian: Jacobian, b: Floats) -> Floats:  # noqa: ARG001 - others need it
    """y + T G y = b: (n_relative, n_coefficients, n_right) -> same, one after the other for a solver not known here"""
    return np.stack([forces(b[..., i]) for i in range(b.shape[2])], axis=2)


@_solve_forces.register
def _(forces: DirectForces, jacobian: Jacobian, b: Floats) -> Floats:
    y = np.zeros_like(b)
    y[jacobian.rows] = forces.solve(b[jacobian.rows])
    return y


@_solve_forces.register
def _(forces: ModalForces, jacobian: Jacobian, b: Floats) -> Floats:
    phi, (n, c, p) = forces._phi, b.shape
    loads = (phi.T @ b.reshape(n, c * p)).reshape(-1, p)
    modal = scipy.linalg.lu_solve(forces._factors, loads, check_finite=False)
    motion = (phi @ modal.reshape(phi.shape[1], c * p)).reshape(b.shape)
    return b - apply_tangents(jacobian.receptance.system, jacobian.departure, motion)


@_solve_forces.register
def _(forces: KrylovForces, jacobian: Jacobian, b: Floats) -> Floats:
    """Directly: from about ten right-hand sides on, one factorisation costs less than as many Krylov spaces, and a
    space shared by all (block GMRES) was not smaller by enough to pay for its orthogonalisation.
    """
    return _solve_forces(forces._direct, jacobian, b)
