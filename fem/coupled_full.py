"""Modes of the spring-coupled rig on the full finite element model, to verify the reduction by.

The coupled stiffness is never factorised: Lanczos applies its inverse through the factorisations of the blade (used
for both) and of the damper on six springs that hold it isostatically, with contacts and wires put in, and those six
springs taken out again, by the Woodbury identity.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from updamp.fem.component import Component, FactorisedComponent
from updamp.fem.interface import BLADE_POINTS
from updamp.fem.modes import SEED
from updamp.fem.reduction import BLOCK
from updamp.fem.rigid_body import rigid_body_fields
from updamp.fem.solvers import Factorisation, LinearSolver
from updamp.fem.springs import Springs

Floats = NDArray[np.float64]

LANCZOS_VECTORS = 16


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
        return self._first(self.tips[:, 0] * self.tips[:, 1] < 0)

    @property
    def in_phase(self) -> int:
        """Number of the first mode whose tips move together: IP."""
        return self._first(self.tips[:, 0] * self.tips[:, 1] > 0)

    def _first(self, of_kind: NDArray[np.bool_]) -> int:
        # Torsion leaves the tips' middle at rest: there the sign would be round-off.
        amplitude = np.abs(self.tips).min(axis=1)
        found = np.flatnonzero(of_kind & (amplitude > 0.1 * amplitude.max()))
        if not len(found):
            raise ValueError(f"no such mode among the first {len(self.tips)}; ask for more coupled modes")
        return int(found[0])


def blade_flexibility(part: FactorisedComponent) -> Floats:
    """B^T K^-1 B (n_interface, n_interface) of the clamped blade [m/N]."""
    return _flexibility(part.component.interface.operator, part.shifted)


def coupled_modes_full(
    blade: FactorisedComponent,
    flexibility: Floats,
    damper: Component,
    solver: LinearSolver,
    springs: Springs,
    n_modes: int = 4,
) -> CoupledModes:
    """The first modes of the left blade, the right blade and the damper on `springs`.

    flexibility: static flexibility of the blade at its interface, from `blade_flexibility` or its reduction
    raises: SolverFailedError, ArpackNoConvergence
    """
    support, ground = _isostatic_support(damper)
    grounded = damper.matrices.stiffness + sparse.bsr_array((support * ground) @ support.T, blocksize=(3, 3))
    prepared = solver(grounded, rigid_body_fields(damper.mesh.nodes))
    try:
        coupled = _CoupledInverse(blade, flexibility, damper, prepared, springs, support, ground)
        n = coupled.n_dofs
        mass = sparse.block_diag(
            [blade.component.matrices.mass, blade.component.matrices.mass, damper.matrices.mass], format="csr"
        )
        _, vectors = eigsh(
            LinearOperator((n, n), matvec=coupled.stiffness, dtype=np.float64),
            n_modes,
            mass,
            sigma=0,
            which="LM",
            v0=np.random.default_rng(SEED).standard_normal(n),
            ncv=max(LANCZOS_VECTORS, 2 * n_modes + 1),
            OPinv=LinearOperator((n, n), matvec=coupled.solve, dtype=np.float64),
            tol=1e-10,
        )
        return _coupled_modes(coupled, mass, vectors)
    finally:
        prepared.close()


class _CoupledInverse:
    """Products with the coupled stiffness and its inverse, (n_dofs,) or (n_dofs, m) -> the same shape."""

    def __init__(self, blade, flexibility, damper, prepared, springs, support, ground):
        self._blade_matrix, self._blade_factor = blade.component.matrices.stiffness, blade.shifted
        self._damper_matrix, self._damper_factor = damper.matrices.stiffness, prepared
        self._blade, self._damper = blade.component.interface.operator, damper.interface.operator
        self._springs, self._support = springs, support
        self._cuts = np.cumsum([self._blade.shape[0]] * 2)
        self._rows = np.cumsum([self._blade.shape[1]] * 2)
        self.n_dofs = 2 * self._blade.shape[0] + self._damper.shape[0]
        # Interface forces per interface displacement that the separate components do not know of.
        stiffness = np.concatenate([springs.stiffness, -ground])
        self._directions = linalg.block_diag(springs.directions, np.eye(len(ground)))
        damper_flexibility = _flexibility(sparse.hstack([self._damper, support], format="csc"), prepared)
        separate = linalg.block_diag(flexibility, flexibility, damper_flexibility)
        seen = self._directions.T @ separate @ self._directions
        self._correction = linalg.solve(np.eye(len(stiffness)) + stiffness[:, None] * seen, np.diag(stiffness))

    def solve(self, load: Floats) -> Floats:
        motion = self._separate(load)
        forces = self._directions @ (self._correction @ (self._directions.T @ self._read(motion, supports=True)))
        return self._separate(load - self._spread(forces, supports=True))

    def stiffness(self, field: Floats) -> Floats:
        left, right, damper = np.split(field, self._cuts)
        own = [self._blade_matrix @ left, self._blade_matrix @ right, self._damper_matrix @ damper]
        springs = self._springs
        elongation = springs.directions.T @ self._read(field, supports=False)
        stiffness = springs.stiffness if field.ndim == 1 else springs.stiffness[:, None]
        return np.concatenate(own) + self._spread(springs.directions @ (stiffness * elongation), supports=False)

    def _separate(self, load: Floats) -> Floats:
        left, right, damper = np.split(load, self._cuts)
        blades = self._blade_factor.solve(np.stack([left.ravel(), right.ravel()], axis=1))
        return np.concatenate([blades[:, 0], blades[:, 1], self._damper_factor.solve(damper.ravel())])

    def _read(self, field: Floats, supports: bool) -> Floats:
        left, right, damper = np.split(field, self._cuts)
        read = [self._blade.T @ left, self._blade.T @ right, self._damper.T @ damper]
        return np.concatenate([*read, self._support.T @ damper] if supports else read)

    def _spread(self, forces: Floats, supports: bool) -> Floats:
        left, right, rest = np.split(forces, self._rows)
        n_damper = self._damper.shape[1]
        damper = self._damper @ rest[:n_damper]
        if supports:
            damper = damper + self._support @ rest[n_damper:]
        return np.concatenate([self._blade @ left, self._blade @ right, damper])

    def split(self, fields: Floats) -> list[Floats]:
        return np.split(fields, self._cuts)


def _coupled_modes(coupled: _CoupledInverse, mass: sparse.csr_array, vectors: Floats) -> CoupledModes:
    values = np.einsum("im,im->m", vectors, coupled.stiffness(vectors))
    order = np.argsort(values)
    omega, vectors = np.sqrt(values[order]), vectors[:, order]
    forces = coupled.stiffness(vectors)
    residual = np.linalg.norm(forces - (mass @ vectors) * omega**2, axis=0) / np.linalg.norm(forces, axis=0)
    left, right, damper = coupled.split(vectors)
    read_tip = coupled._blade[:, [coupled._blade.shape[1] - len(BLADE_POINTS) + BLADE_POINTS.index("tip.x")]].T
    tips = np.stack([-(read_tip @ left)[0], (read_tip @ right)[0]], axis=1)
    return CoupledModes(omega / (2 * np.pi), left, right, damper, tips, float(residual.max()))


def _flexibility(operator: sparse.csc_array, factor: Factorisation) -> Floats:
    flexibility = np.empty((operator.shape[1], operator.shape[1]))
    for start in range(0, operator.shape[1], BLOCK):
        columns = slice(start, start + BLOCK)
        flexibility[:, columns] = operator.T @ factor.solve(operator[:, columns].toarray(order="F"))
    return (flexibility + flexibility.T) / 2


def _isostatic_support(damper: Component) -> tuple[sparse.csc_array, Floats]:
    """Six springs at three nodes far apart (3-2-1), as stiff as the damper's own nodes.

    returns: directions (n_dofs, 6), stiffness (6,) [N/m]
    """
    nodes = damper.mesh.nodes
    first = int(np.linalg.norm(nodes - nodes.mean(axis=0), axis=1).argmax())
    second = int(np.linalg.norm(nodes - nodes[first], axis=1).argmax())
    line = (nodes[second] - nodes[first]) / np.linalg.norm(nodes[second] - nodes[first])
    across = nodes - nodes[first] - np.outer((nodes - nodes[first]) @ line, line)
    third = int(np.linalg.norm(across, axis=1).argmax())
    sideways = across[third] / np.linalg.norm(across[third])
    upright = np.cross(line, sideways)
    held = [(first, line), (first, sideways), (first, upright), (second, sideways), (second, upright), (third, upright)]
    rows = np.concatenate([3 * node + np.arange(3) for node, _ in held])
    values = np.concatenate([direction for _, direction in held])
    support = sparse.csc_array((values, (rows, np.repeat(np.arange(6), 3))), shape=(3 * len(nodes), 6))
    return support, np.full(6, damper.matrices.stiffness.diagonal().mean())
