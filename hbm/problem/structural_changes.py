"""Changes of the linear structure at named points: springs, dashpots and masses, exact in spite of truncated modes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.problem.linear_model import LinearModel, add_springs
from updamp.hbm.problem.modal_algebra import graded_eigh

Floats = NDArray[np.float64]

ROUND_OFF = 1e-10  # residual flexibility at a point, relative to all, below which there is none
ABOVE_LOWEST, ABOVE_HIGHEST = 3e11, 1e6  # see _least_inertia


@dataclass(frozen=True, eq=False)
class Attachment:
    """What acts on the displacement sum_i weight_i u_i of named points.

    points: name -> weight; stiffness [N/m], dashpot [N s/m], mass [kg]
    raises: ValueError for a negative mass
    """

    name: str
    points: Mapping[str, float] = field(default_factory=dict)
    stiffness: float = 0.0
    dashpot: float = 0.0
    mass: float = 0.0

    def __post_init__(self) -> None:
        if self.mass < 0:
            raise ValueError(f"attachment {self.name} has a mass of {self.mass:g} kg: give one that is not negative")

    def direction(self, model: LinearModel) -> Floats:
        """(n_rows,); raises: KeyError for a point that is not in the model"""
        direction = np.zeros(model.n_rows)
        for point, weight in self.points.items():
            direction[model.row(point)] += weight
        return direction


def attach(model: LinearModel, attachments: Sequence[Attachment]) -> LinearModel:
    """The model with all of them: exact, whatever the modal truncation.

    Masses and dashpots move with the residual flexibility too. What it lets their points move by beyond the modes
    becomes a mode of its own, of high frequency: one for each independent displacement that they act on, if it has
    residual flexibility.
    """
    springs = [a for a in attachments if a.stiffness != 0]
    if springs:
        directions = np.stack([a.direction(model) for a in springs], axis=1)
        model = add_springs(model, directions, np.array([a.stiffness for a in springs]))
    dynamic = [a for a in attachments if a.mass != 0 or a.dashpot != 0]
    if not dynamic:
        return model
    directions = np.stack([a.direction(model) for a in dynamic], axis=1)
    return add_inertia(model, directions, np.array([a.mass for a in dynamic]), np.array([a.dashpot for a in dynamic]))


def add_inertia(model: LinearModel, directions: Floats, mass: Floats, dashpot: Floats) -> LinearModel:
    """The model with masses and dashpots on the displacements y = V^T (phi q + R f).

    The residual flexibility is split into what V's forces drive and the rest: R = A A^T + R', A = R V U rho^-1/2 with
    V^T R V = U rho U^T. The former becomes modes p of unit stiffness with the shapes A (residual attachment modes, as
    in Craig and Chang 1977), R' does not move V. So y = V^T (phi q + A p): masses and dashpots act on modes alone.
    The new modes are brought to unit mass; inertia below `_least_inertia`, as with a dashpot alone, is raised to that.

    directions V: (n_rows, k); mass: (k,) not negative [kg]; dashpot: (k,) [N s/m]
    """
    shapes = _residual_modes(model, directions)
    inertia, T = scipy.linalg.eigh((directions.T @ shapes).T * mass @ (directions.T @ shapes))
    inertia = np.maximum(inertia, _least_inertia(model, directions))
    grown = shapes @ T / np.sqrt(inertia)
    phi = np.hstack([model.phi, grown])
    moved = directions.T @ phi
    old, none = len(model.omega_squared), np.zeros((len(inertia),) * 2)
    added = moved.T * mass @ moved
    added[old:, old:] = none  # it is what brought the new modes to unit mass
    residual = model.residual - shapes @ shapes.T
    # the new modes last: the factor then keeps their large stiffness away from the others
    inverse = scipy.linalg.solve_triangular(
        np.linalg.cholesky(np.eye(len(added)) + added), np.eye(len(added)), lower=True
    )
    stiffness = inverse * np.concatenate([model.omega_squared, 1 / inertia]) @ inverse.T
    omega_squared, Q = graded_eigh((stiffness + stiffness.T) / 2)
    X = inverse.T @ Q
    viscous = scipy.linalg.block_diag(model.viscous, none) + moved.T * dashpot @ moved
    return replace(
        model,
        omega_squared=omega_squared,
        phi=phi @ X,
        residual=(residual + residual.T) / 2,
        hysteretic=X.T @ scipy.linalg.block_diag(model.hysteretic, none) @ X,
        viscous=X.T @ viscous @ X,
        basis=None,
    )


def _residual_modes(model: LinearModel, directions: Floats) -> Floats:
    """(n_rows, p) A, p the rank of the residual flexibility between the directions [(m/N)^1/2]"""
    driven = model.residual @ directions
    sizes, U = scipy.linalg.eigh(directions.T @ driven)
    elastic = model.omega_squared > 0
    by_modes = np.sum((directions.T @ model.phi[:, elastic]) ** 2 / model.omega_squared[elastic])
    kept = sizes > ROUND_OFF * max(by_modes, *np.abs(sizes))
    return np.asarray(driven @ U[:, kept] / np.sqrt(sizes[kept]))


def _least_inertia(model: LinearModel, directions: Floats) -> float:
    """Of a new mode of unit stiffness [s^2]: as at a frequency far above what is vibrated at, which is taken to be of
    the order of the lowest modes that the directions feel, or among the modes at all. The error at w is w^2 times this.

    Without bound the dynamic stiffness would be ill-conditioned.
    """
    elastic = model.omega_squared > 0
    omega_squared = model.omega_squared[elastic]
    felt = np.sum((directions.T @ model.phi[:, elastic]) ** 2, axis=0) / omega_squared
    lowest = felt.sum() / max(np.sum(felt / omega_squared), np.finfo(float).tiny)
    highest = omega_squared.max(initial=0.0)
    return float(1 / max(ABOVE_LOWEST * lowest, ABOVE_HIGHEST * highest, np.finfo(float).tiny))


def with_relative_rows(model: LinearModel, points: Sequence[str]) -> LinearModel:
    """The model with the displacements of named points as further relative rows, for elements to act on."""
    if not points:
        return model
    n = model.n_relative
    order = np.array([*range(n), *(model.row(p) for p in points), *range(n, model.n_rows)])
    return replace(
        model,
        phi=model.phi[order],
        residual=model.residual[np.ix_(order, order)],
        n_relative=n + len(points),
    )
