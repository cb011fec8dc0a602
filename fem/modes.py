"""Normal modes of one component by shift-invert Lanczos (ARPACK), rigid-body modes in closed form."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from updamp.fem.component import FactorisedComponent

Floats = NDArray[np.float64]
Product = Callable[[Floats], Floats]

LANCZOS_VECTORS = 60  # about 60 solves for 24 modes; fewer vectors cost restarts
SEED = 20170301
RESIDUAL_LIMIT = 1e-6


class InaccurateModesError(RuntimeError):
    """The modes do not satisfy their equation to RESIDUAL_LIMIT."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Mass-normalised modes in ascending order.

    omega: (n_modes,) [rad/s], exactly 0 for rigid-body modes
    phi: (n_dofs, n_modes) on the free nodes [kg^-1/2]
    max_relative_residual: largest ||K phi - omega^2 M phi|| / ||K phi|| of the elastic modes [-]
    """

    omega: Floats
    phi: Floats
    max_relative_residual: float

    @property
    def frequencies(self) -> Floats:
        """(n_modes,) [Hz]"""
        return self.omega / (2 * np.pi)

    @property
    def n_rigid(self) -> int:
        return int((self.omega == 0).sum())


def normal_modes(part: FactorisedComponent, n_modes: int) -> Modes:
    """The lowest modes, rigid-body modes included.

    Rigid-body modes are projected out of every load and every response, so that the search sees the exact static
    response of a free component, and its elastic modes are orthogonal to them to round-off.

    raises: InaccurateModesError, ValueError for more modes than the mesh can give
    """
    matrices, rigid = part.component.matrices, part.component.rigid
    n_dofs = matrices.n_dofs
    n_elastic = n_modes - rigid.shape[1]
    vectors = min(max(LANCZOS_VECTORS, 2 * n_elastic + 1), n_dofs - 1)
    if not 0 < n_elastic < vectors:
        raise ValueError(
            f"reduction.modes = {n_modes} is not possible with {rigid.shape[1]} rigid-body modes and {n_dofs} degrees "
            f"of freedom; choose between {rigid.shape[1] + 1} and {n_dofs - 2 + rigid.shape[1]}"
        )
    elastic = _elastic_modes(part, n_elastic, vectors)
    # Rayleigh's quotient: its error is the square of the mode's.
    omega = np.sqrt(np.einsum("im,im->m", elastic, matrices.stiffness @ elastic))
    residual = relative_residuals(matrices.stiffness.dot, matrices.mass.dot, omega, elastic).max()
    _check(residual)
    return Modes(
        np.concatenate([np.zeros(rigid.shape[1]), omega]), np.asfortranarray(np.hstack([rigid, elastic])), residual
    )


def _elastic_modes(part: FactorisedComponent, n_modes: int, vectors: int) -> Floats:
    """(n_dofs, n_modes) in ascending order, orthogonal to the rigid-body modes; vectors: of the Krylov space"""
    matrices, rigid = part.component.matrices, part.component.rigid
    mass_rigid, n_dofs = matrices.mass @ rigid, matrices.n_dofs

    def search(load: Floats) -> Floats:
        motion = part.factor.solve(load - mass_rigid @ (rigid.T @ load))
        return motion - rigid @ (mass_rigid.T @ motion)

    start = np.random.default_rng(SEED).standard_normal(n_dofs)
    values, elastic = eigsh(
        matrices.stiffness,
        n_modes,
        matrices.mass,
        sigma=0,
        which="LM",
        v0=start - rigid @ (mass_rigid.T @ start),
        ncv=vectors,
        OPinv=LinearOperator((n_dofs, n_dofs), matvec=search, dtype=np.float64),
    )
    elastic = elastic[:, np.argsort(values)]
    return np.asarray(elastic - rigid @ (mass_rigid.T @ elastic))


def relative_residuals(stiffness: Product, mass: Product, omega: Floats, phi: Floats) -> Floats:
    """(n_modes,) ||K phi - omega^2 M phi|| / ||K phi|| [-]. stiffness, mass: functions that multiply by K, M"""
    forces = stiffness(phi)
    return np.linalg.norm(forces - mass(phi) * omega**2, axis=0) / np.linalg.norm(forces, axis=0)


def _check(residual: float) -> None:
    if not residual < RESIDUAL_LIMIT:
        raise InaccurateModesError(
            f"modes: the largest relative residual is {residual:.1e}, {RESIDUAL_LIMIT:.0e} is allowed; ask for fewer "
            "modes, or use a direct solver (reduction.solver = 'pardiso' or 'cholmod')"
        )
