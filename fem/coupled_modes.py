"""Modes of the spring-coupled rig on the full finite element model and from the reduced one, to verify the reduction.

The coupled stiffness is never factorised: Lanczos applies its inverse through the factorisations of the blade (used
for both) and of the damper on its isostatic support. Contacts and wires are put in, and the support is taken out
again, by the Woodbury identity.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from updamp.fem.component import FactorisedComponent
from updamp.fem.interface import BLADE_POINTS
from updamp.fem.modes import SEED, relative_residuals
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.reduction import BLOCK
from updamp.fem.springs import Springs

Floats = NDArray[np.float64]
Product = Callable[[Floats], Floats]

MODES = 4  # which have the first bending modes, OOP and IP, among them
LANCZOS_VECTORS = 16
LANCZOS_TOLERANCE = 1e-9  # of the eigenvalue; half of it is the frequency's


@dataclass(frozen=True, eq=False)
class CoupledModes:
    """Mass-normalised modes of blades and damper together, ascending.

    frequencies: (n,) [Hz]
    blade_left, blade_right: (n_blade_dofs, n), the left one's mirrored (x -> -x) as all of the left blade is
    damper: (n_damper_dofs, n) [kg^-1/2]
    tips: (n, 2) displacement of the left and the right tip along the global x [kg^-1/2]
    max_relative_residual: largest ||K phi - omega^2 M phi|| / ||K phi|| [-]
    """

    frequencies: Floats
    blade_left: Floats
    blade_right: Floats
    damper: Floats
    tips: Floats
    max_relative_residual: float

    @property
    def out_of_phase(self) -> int:
        """Number of the first mode whose tips move against each other: OOP."""
        return first_mode(self.tips, in_phase=False)

    @property
    def in_phase(self) -> int:
        """Number of the first mode whose tips move together: IP."""
        return first_mode(self.tips, in_phase=True)


def first_mode(tips: Floats, in_phase: bool) -> int:
    """Number of the first mode whose tips move together, or against each other.

    tips: (n, 2) displacement of the left and the right tip along the global x
    raises: ValueError where there is none
    """
    # Torsion leaves the tips' middle at rest: there the sign would be round-off.
    amplitude = np.abs(tips).min(axis=1)
    of_kind = (tips[:, 0] * tips[:, 1] > 0) == in_phase
    found = np.flatnonzero(of_kind & (amplitude > 0.1 * amplitude.max()))
    if not len(found):
        raise ValueError(f"no such mode among the first {len(tips)}; ask for more coupled modes")
    return int(found[0])


def static_flexibility(part: FactorisedComponent) -> Floats:
    """B^T K^-1 B (n_interface, n_interface) of a clamped component [m/N]."""
    return _flexibility(part.component.interface.operator, part)


def coupled_modes_full(
    blade: FactorisedComponent, damper: FactorisedComponent, flexibility: Floats, springs: Springs
) -> CoupledModes:
    """The first `MODES` of the left blade, the right blade and the damper on `springs`.

    flexibility: static flexibility of the blade at its interface, from `static_flexibility` or its reduction
    raises: SolverFailedError, ArpackNoConvergence
    """
    coupled = _CoupledSystem(blade, damper, flexibility, springs)
    n = coupled.n_dofs

    def operator(product: Product) -> LinearOperator:
        return LinearOperator((n, n), matvec=product, matmat=product, dtype=np.float64)

    _, vectors = eigsh(
        operator(coupled.stiffness),
        MODES,
        operator(coupled.mass),
        sigma=0,
        which="LM",
        v0=np.random.default_rng(SEED).standard_normal(n),
        ncv=LANCZOS_VECTORS,
        OPinv=operator(coupled.solve),
        tol=LANCZOS_TOLERANCE,
    )
    return _coupled_modes(coupled, vectors)


class _CoupledSystem:
    """Products with the coupled stiffness, its inverse and the mass, (n_dofs,) or (n_dofs, m) -> the same shape."""

    def __init__(
        self, blade: FactorisedComponent, damper: FactorisedComponent, flexibility: Floats, springs: Springs
    ) -> None:
        self._blade, self._damper, self._springs = blade, damper, springs
        self._blade_operator = blade.component.interface.operator
        support = damper.component.support
        self._damper_operator = sparse.hstack([damper.component.interface.operator, support.directions], format="csc")
        self._cuts = np.cumsum([self._blade_operator.shape[0]] * 2)
        self._rows = np.cumsum([self._blade_operator.shape[1]] * 2)
        self.n_dofs = 2 * self._blade_operator.shape[0] + self._damper_operator.shape[0]
        # What the separate components do not know of: the springs, and that the support is not there.
        self._directions = linalg.block_diag(springs.directions, np.eye(len(support.stiffness)))
        stiffness = np.concatenate([springs.stiffness, -support.stiffness])
        separate = linalg.block_diag(flexibility, flexibility, _flexibility(self._damper_operator, damper))
        at_springs = self._directions.T @ separate @ self._directions
        self._correction = linalg.solve(np.eye(len(stiffness)) + stiffness[:, None] * at_springs, np.diag(stiffness))

    def solve(self, load: Floats) -> Floats:
        motion = self._separate(load)
        forces = self._directions @ (self._correction @ (self._directions.T @ self._read(motion)))
        return self._separate(load - self._spread(forces))

    def stiffness(self, field: Floats) -> Floats:
        left, right, damper = self.split(field)
        blade = self._blade.component.matrices.stiffness
        own = [blade @ left, blade @ right, self._damper.component.matrices.stiffness @ damper]
        read = self._read(field)
        n_springs = len(self._springs.stiffness)
        elongation = self._directions[:, :n_springs].T @ read
        tension = (elongation.T * self._springs.stiffness).T
        return np.concatenate(own) + self._spread(self._directions[:, :n_springs] @ tension)

    def mass(self, field: Floats) -> Floats:
        left, right, damper = self.split(field)
        blade = self._blade.component.matrices.mass
        return np.concatenate([blade @ left, blade @ right, self._damper.component.matrices.mass @ damper])

    def tips(self, field: Floats) -> Floats:
        """(n, 2) x displacement of the left and the right tip; the left blade is mirrored"""
        left, right, _ = np.split(self._read(field), self._rows)
        row = len(left) - len(BLADE_POINTS) + BLADE_POINTS.index("tip.x")
        return np.stack([-left[row], right[row]], axis=1)

    def split(self, field: Floats) -> list[Floats]:
        return np.split(field, self._cuts)

    def _separate(self, load: Floats) -> Floats:
        left, right, damper = self.split(load)
        blades = self._blade.solve(np.stack([left.ravel(), right.ravel()], axis=1))
        return np.concatenate([blades[:, 0], blades[:, 1], self._damper.solve(damper.ravel())])

    def _read(self, field: Floats) -> Floats:
        left, right, damper = self.split(field)
        return np.concatenate(
            [self._blade_operator.T @ left, self._blade_operator.T @ right, self._damper_operator.T @ damper]
        )

    def _spread(self, forces: Floats) -> Floats:
        left, right, damper = np.split(forces, self._rows)
        return np.concatenate(
            [self._blade_operator @ left, self._blade_operator @ right, self._damper_operator @ damper]
        )


def _coupled_modes(coupled: _CoupledSystem, vectors: Floats) -> CoupledModes:
    forces = coupled.stiffness(vectors)
    values = np.einsum("im,im->m", vectors, forces)
    order = np.argsort(values)
    omega, vectors = np.sqrt(values[order]), vectors[:, order]
    residual = relative_residuals(forces[:, order], coupled.mass(vectors), omega).max()
    left, right, damper = coupled.split(vectors)
    return CoupledModes(omega / (2 * np.pi), left, right, damper, coupled.tips(vectors), float(residual))


def _flexibility(operator: sparse.csc_array, part: FactorisedComponent) -> Floats:
    flexibility = np.empty((operator.shape[1], operator.shape[1]))
    for start in range(0, operator.shape[1], BLOCK):
        columns = slice(start, start + BLOCK)
        flexibility[:, columns] = operator.T @ part.solve(operator[:, columns].toarray(order="F"))
    return (flexibility + flexibility.T) / 2


def coupled_frequencies_reduced(reduced: ReducedModel, springs: Springs, n_modes: int = 4) -> Floats:
    """(n_modes,) [Hz], ascending.

    y = Phi q + R f and f = -V S V^T y give, with P = V^T Phi, (diag(omega^2) + P^T (S^-1 + V^T R V)^-1 P) q = w^2 q.
    """
    residual = linalg.block_diag(*(component.residual for component in reduced.components))
    phi = linalg.block_diag(*(component.phi for component in reduced.components))
    omega = np.concatenate([component.omega for component in reduced.components])
    at_springs = springs.directions.T @ phi
    compliance = np.diag(1 / springs.stiffness) + springs.directions.T @ residual @ springs.directions
    stiffness = np.diag(omega**2) + at_springs.T @ linalg.solve(compliance, at_springs, assume_a="pos")
    values = linalg.eigh((stiffness + stiffness.T) / 2, eigvals_only=True, subset_by_index=[0, n_modes - 1])
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi)
