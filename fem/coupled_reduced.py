"""Modes of the spring-coupled rig from the reduced model."""

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.springs import Springs

Floats = NDArray[np.float64]


def coupled_frequencies_reduced(reduced: ReducedModel, springs: Springs, n_modes: int = 4) -> Floats:
    """(n_modes,) [Hz], ascending.

    y = Phi q + R f and f = -V S V^T y give, with P = V^T Phi, (diag(omega^2) + P^T (S^-1 + V^T R V)^-1 P) q = w^2 q.
    """
    residual = linalg.block_diag(*(component.residual for component in reduced.components))
    phi = linalg.block_diag(*(component.phi for component in reduced.components))
    omega = np.concatenate([component.omega for component in reduced.components])
    seen = springs.directions.T @ phi
    compliance = np.diag(1 / springs.stiffness) + springs.directions.T @ residual @ springs.directions
    stiffness = np.diag(omega**2) + seen.T @ linalg.solve(compliance, seen, assume_a="pos")
    values = linalg.eigh((stiffness + stiffness.T) / 2, eigvals_only=True, subset_by_index=[0, n_modes - 1])
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi)
