"""Normal modes of one component by shift-invert Lanczos (ARPACK), rigid-body modes in closed form."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from updamp.fem.component import FactorisedComponent
from updamp.fem.half_models import Subspace
from updamp.fem.solvers import Factorisation

Floats = NDArray[np.float64]

# Of the Krylov space, for n modes 30 + 1.25 n: as many solves, without a restart, for 12 to 24 modes of a blade and of
# its halves; fewer vectors cost restarts.
VECTORS, VECTORS_A_MODE = 30, 1.25
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
    if not 0 < n_elastic < n_dofs - 1:
        raise ValueError(
            f"reduction.modes = {n_modes} is not possible with {rigid.shape[1]} rigid-body modes and {n_dofs} degrees "
            f"of freedom; choose between {rigid.shape[1] + 1} and {n_dofs - 2 + rigid.shape[1]}"
        )
    elastic = _elastic_modes(part, n_elastic)
    # Rayleigh's quotient: its error is the square of the mode's.
    forces = matrices.stiffness @ elastic
    omega = np.sqrt(np.einsum("im,im->m", elastic, forces))
    residual = relative_residuals(forces, matrices.mass @ elastic, omega).max()
    _check(residual)
    return Modes(
        np.concatenate([np.zeros(rigid.shape[1]), omega]), np.asfortranarray(np.hstack([rigid, elastic])), residual
    )


def _elastic_modes(part: FactorisedComponent, n_modes: int) -> Floats:
    """(n_dofs, n_modes) in ascending order, orthogonal to the rigid-body modes.

    Of two subspaces each is first asked for half of them and two more; for all, should it hold more of the lowest.
    """
    shares = (n_modes,) if len(part.factors) == 1 else (min(n_modes // 2 + 2, n_modes), n_modes)
    for share in shares:
        found = [_lowest_modes(part, subspace, factor, share) for subspace, factor in part.factors]
        values = np.concatenate([own for own, _ in found])
        lowest = np.argsort(values, kind="stable")[:n_modes]
        if min(own.max() for own, _ in found) >= values[lowest[-1]]:
            break  # what was not asked for lies above
    return np.hstack([modes for _, modes in found])[:, lowest]


def _lowest_modes(
    part: FactorisedComponent, subspace: Subspace, factor: Factorisation, n_modes: int
) -> tuple[Floats, Floats]:
    """Of one subspace: omega^2 (n_modes,) and the modes (n_dofs, n_modes), in no order."""
    mass, n = part.component.matrices.mass, subspace.stiffness.shape[0]
    rigid, mass_rigid = subspace.within(part.component.rigid), subspace.within(mass @ part.component.rigid)

    def search(load: Floats) -> Floats:
        motion = factor.solve(load - mass_rigid @ (rigid.T @ load))
        return motion - rigid @ (mass_rigid.T @ motion)

    def inertia(motion: Floats) -> Floats:
        return subspace.within(mass @ subspace.outside(motion))

    start = np.random.default_rng(SEED).standard_normal(n)
    values, modes = eigsh(
        subspace.stiffness,
        n_modes,
        LinearOperator((n, n), matvec=inertia, dtype=np.float64),
        sigma=0,
        which="LM",
        v0=start - rigid @ (mass_rigid.T @ start),
        ncv=min(VECTORS + int(VECTORS_A_MODE * n_modes), n - 1),
        OPinv=LinearOperator((n, n), matvec=search, dtype=np.float64),
    )
    return values, subspace.outside(modes - rigid @ (mass_rigid.T @ modes))


def relative_residuals(forces: Floats, momenta: Floats, omega: Floats) -> Floats:
    """(n_modes,) ||K phi - omega^2 M phi|| / ||K phi|| [-]. forces, momenta: (n_dofs, n_modes) K phi and M phi"""
    return np.linalg.norm(forces - momenta * omega**2, axis=0) / np.linalg.norm(forces, axis=0)


def _check(residual: float) -> None:
    if not residual < RESIDUAL_LIMIT:
        raise InaccurateModesError(
            f"modes: the largest relative residual is {residual:.1e}, {RESIDUAL_LIMIT:.0e} is allowed; ask for fewer "
            "modes, or use a direct solver (reduction.solver = 'pardiso' or 'cholmod')"
        )
