"""Changes of the linear structure at named points: springs exactly, dashpots and masses through the modes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.linear_model import LinearModel, add_springs

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Attachment:
    """What acts on the displacement sum_i weight_i u_i of named points.

    points: name -> weight; stiffness [N/m], dashpot [N s/m], mass [kg]
    """

    name: str
    points: Mapping[str, float] = field(default_factory=dict)
    stiffness: float = 0.0
    dashpot: float = 0.0
    mass: float = 0.0

    def direction(self, model: LinearModel) -> Floats:
        """(n_rows,); raises: KeyError for a point that is not in the model"""
        direction = np.zeros(model.n_rows)
        for point, weight in self.points.items():
            direction[model.row(point)] += weight
        return direction


def attach(model: LinearModel, attachments: Sequence[Attachment]) -> LinearModel:
    """The model with all of them.

    Springs are exact. Masses and dashpots act through the modes alone: what they do by way of the residual
    flexibility, of the order of its displacement over the modes', is left out.
    """
    springs = [a for a in attachments if a.stiffness != 0]
    if springs:
        directions = np.stack([a.direction(model) for a in springs], axis=1)
        model = add_springs(model, directions, np.array([a.stiffness for a in springs]))
    viscous = model.viscous.copy()
    mass = np.eye(len(model.omega_squared))
    for attachment in attachments:
        shape = attachment.direction(model) @ model.phi
        viscous += attachment.dashpot * np.outer(shape, shape)
        mass += attachment.mass * np.outer(shape, shape)
    model = replace(model, viscous=viscous)
    return with_modal_matrices(model, mass=mass) if any(a.mass for a in attachments) else model


def with_modal_matrices(
    model: LinearModel, stiffness_change: Floats | None = None, mass: Floats | None = None
) -> LinearModel:
    """The model with other modal matrices, brought back to its own modes.

    stiffness_change: (m, m) added to diag(omega_squared) [rad^2/s^2]; mass: (m, m) instead of the identity [-]
    """
    K = np.diag(model.omega_squared)
    K = K if stiffness_change is None else K + stiffness_change
    omega_squared, X = scipy.linalg.eigh(K) if mass is None else scipy.linalg.eigh(K, mass)
    return replace(
        model,
        omega_squared=omega_squared,
        phi=model.phi @ X,
        hysteretic=X.T @ model.hysteretic @ X,
        viscous=X.T @ model.viscous @ X,
        basis=None,
    )


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
