"""The stuck structure with few modes that have mass: all that moves slowly, and the rest as flexibility without mass.

A perturbation of a response at w moves at up to some multiples of w. Stiffer motion follows the contact forces without
inertia: it joins the residual flexibility. Slow are the stuck structure's lowest modes, and those of the structure on
its contacts' mean stiffness: a damper whose contacts are open most of the time is as slow as its wires, while its mass
lies in stuck modes of many kilohertz.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]

FEW = 12  # modes: so many are all kept
INDEPENDENT = 1e-6  # smallest part of a mode outside the others, below which it adds nothing


@dataclass(frozen=True, eq=False)
class CondensedStructure:
    """omega_squared: (m,) [rad^2/s^2], damping: (m, m) viscous [1/s], phi: (n_relative, m) [kg^-1/2] of the kept modes;
    flexibility: (n_relative, n_relative) of all else, without mass [m/N]
    """

    omega_squared: Floats
    damping: Floats
    phi: Floats
    flexibility: Floats

    def __len__(self) -> int:
        return len(self.omega_squared)


def viscous_damping(stuck: LinearModel) -> Floats:
    """(m, m) [1/s]: structural damping as the viscous one that equals it at each mode's own frequency."""
    omega = np.sqrt(np.maximum(stuck.omega_squared, np.finfo(float).tiny))
    return stuck.viscous + stuck.hysteretic / np.sqrt(np.outer(omega, omega))


def condense(stuck: LinearModel, mean_tangent: Floats, highest: float) -> CondensedStructure:
    """Keep what moves more slowly than `highest` [rad/s], contacts stuck or on their mean stiffness.

    mean_tangent: (n_relative, n_relative) departure of that stiffness from the stuck one [N/m]
    """
    n, phi, damping = stuck.n_relative, stuck.phi[: stuck.n_relative], viscous_damping(stuck)
    residual = stuck.residual[:n, :n]
    if len(stuck.omega_squared) <= FEW:
        return CondensedStructure(stuck.omega_squared, damping, phi, residual)
    B = _slow(stuck.omega_squared, phi, residual, mean_tangent, highest)
    omega_squared, turn = scipy.linalg.eigh(B.T @ (stuck.omega_squared[:, None] * B))
    B = B @ turn
    elsewhere = phi / np.sqrt(stuck.omega_squared)  # flexibility of all modes, less that of the kept ones
    flexibility = residual + elsewhere @ elsewhere.T - (phi @ B / omega_squared) @ (phi @ B).T
    return CondensedStructure(omega_squared, B.T @ damping @ B, phi @ B, (flexibility + flexibility.T) / 2)


def _slow(omega_squared: Floats, phi: Floats, residual: Floats, mean_tangent: Floats, highest: float) -> Floats:
    """(m, kept) orthonormal, in the stuck modes."""
    rows = np.flatnonzero((mean_tangent != 0).any(axis=0) | (mean_tangent != 0).any(axis=1))
    T = mean_tangent[np.ix_(rows, rows)]
    softened = np.linalg.solve(np.eye(len(rows)) + T @ residual[np.ix_(rows, rows)], T)
    stiffness = np.diag(omega_squared) + phi[rows].T @ ((softened + softened.T) / 2) @ phi[rows]
    values, vectors = scipy.linalg.eigh(stiffness)
    stuck = np.eye(len(omega_squared))[:, omega_squared < highest**2]
    left, sizes, _ = np.linalg.svd(np.hstack([stuck, vectors[:, values < highest**2]]), full_matrices=False)
    return np.asarray(left[:, sizes > INDEPENDENT * sizes[0]]) if sizes.size else stuck
