"""Hill's eigenproblem of a periodic response: exponents s of perturbations e^(s t) p(t) (Hill 1886; Groll and Ewins
2001 for the harmonic balance), in the modes of the stuck structure.

    L(s) q = (s + w D)^2 q + C (s + w D) q + Omega^2 q + P(s) q = 0,   D the derivative with respect to w t

P(s) are the contacts' departures from stuck seen by the modes; the residual flexibility, which has no mass, is
eliminated. Structural (hysteretic) damping is taken as the viscous damping that equals it at each mode's own frequency.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.analysis.perturbed_forces import perturbed_tangent
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.tangent import NEGLIGIBLE
from updamp.hbm.problem.elements import ElementGroup, over_period
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

ELASTIC = 1e-8  # departure from the reference springs, relative to the force, below which there is none


@dataclass(frozen=True, eq=False)
class HillProblem:
    """x: (n_relative, n_coefficients) [m] in the system's harmonics; w [rad/s]; perturbations: harmonics 0..order"""

    system: NonlinearSystem
    x: Floats
    w: float
    order: int
    time_samples: int

    @cached_property
    def harmonics(self) -> Harmonics:
        return Harmonics(tuple(range(self.order + 1)))

    @cached_property
    def damping(self) -> Floats:
        """(m, m) viscous [1/s]"""
        stuck = self.system.stuck
        omega = np.sqrt(np.maximum(stuck.omega_squared, np.finfo(float).tiny))
        return stuck.viscous + stuck.hysteretic / np.sqrt(np.outer(omega, omega))

    @cached_property
    def derivative(self) -> Floats:
        """(n_coefficients, n_coefficients) of the coefficients with respect to w t"""
        matrix = np.zeros((self.harmonics.n_coefficients,) * 2)
        for k, place in self.harmonics.slices.items():
            if k:
                matrix[place, place] = [[0, k], [-k, 0]]
        return matrix

    def contact_stiffness(self, s: complex) -> Complex:
        """P(s): (m c, m c), ordered (mode, coefficient) [1/s^2]"""
        system, stuck = self.system, self.system.stuck
        x = system.harmonics.change_to(self.harmonics, self.x)
        m, c, n = len(stuck.omega_squared), self.harmonics.n_coefficients, stuck.n_relative
        loads = np.zeros((n, c, m, c), dtype=np.complex128)  # T phi
        active, tiny = np.zeros(n, dtype=bool), np.finfo(float).tiny
        onto = np.zeros((n, c, n, c), dtype=np.complex128) if stuck.has_residual else None  # T R
        for group, elastic in zip(system.groups, self._elastic, strict=True):
            tangent = perturbed_tangent(group, x[group.rows], self.w, s, self.harmonics, self.time_samples).copy()
            stiffness = system.reference_stiffness[group.rows]
            for d in range(tangent.shape[1]):
                tangent[:, d, :, d, :] -= stiffness[:, d, None, None] * np.eye(c)
            loads[group.rows] = np.einsum("idaeb,iem->idamb", tangent, stuck.phi[group.rows])
            tangent[elastic] = 0.0
            active[group.rows] = np.abs(tangent).max(axis=(2, 3, 4)) > NEGLIGIBLE * np.maximum(stiffness, tiny)
            if onto is not None:
                onto[group.rows] = np.einsum("idaeb,ien->idanb", tangent, stuck.residual[group.rows][..., :n])
        if onto is not None:
            loads = _without_residual(loads, onto, np.flatnonzero(active))
        generalised = np.tensordot(stuck.phi[:n].T, loads, axes=1)
        return generalised.reshape(m * c, m * c)

    @cached_property
    def _elastic(self) -> tuple[NDArray[np.bool_], ...]:
        """For each group (n_elements, directions): which forces follow the reference springs. Computed once."""
        return tuple(self._follows_springs(group) for group in self.system.groups)

    def _follows_springs(self, group: ElementGroup) -> NDArray[np.bool_]:
        """(n_elements, directions) whose force follows the reference springs about a mean over the whole period.

        Among them are sliders that have shaken down: pushed, in the first periods, to where the motion just touches
        the slip limit and no longer moves them. Sampled, their tangent there is a matter of round-off; a perturbation
        that decays leaves them at rest somewhere beside, which is stuck.
        """
        x, force = over_period(
            group, group.law.force, self.x[group.rows], self.w, self.system.harmonics, self.time_samples
        )
        stiffness = self.system.reference_stiffness[group.rows]
        beyond = force - stiffness[:, None, :] * x
        size = stiffness * np.ptp(x, axis=1) + np.abs(force).max(axis=1)
        elastic: NDArray[np.bool_] = np.ptp(beyond, axis=1) <= ELASTIC * size
        return elastic

    @cached_property
    def _linear(self) -> tuple[Floats, Floats]:
        """Factors of s and of 1 in L(s), contacts stuck."""
        stuck, w = self.system.stuck, self.w
        identity = np.eye(self.harmonics.n_coefficients)
        modes = np.eye(len(stuck.omega_squared))
        by_s = 2 * w * np.kron(modes, self.derivative) + np.kron(self.damping, identity)
        constant = (
            w**2 * np.kron(modes, self.derivative @ self.derivative)
            + w * np.kron(self.damping, self.derivative)
            + np.kron(np.diag(stuck.omega_squared), identity)
        )
        return by_s, constant

    def eigen(self) -> tuple[Complex, Complex]:
        """All exponents [1/s] and their modes (m c, n), the contacts answering as at s = 0."""
        by_s, constant = self._linear
        contact = self.contact_stiffness(0.0).real
        size = len(by_s)
        companion = np.block([[np.zeros((size, size)), np.eye(size)], [-(constant + contact), -by_s]])
        values, vectors = scipy.linalg.eig(companion, check_finite=False)
        return values, vectors[:size].astype(np.complex128)

    def refine(self, s: complex, q: Complex, tolerance: float) -> tuple[complex, Complex, bool]:
        """Newton's method on L(s) q = 0 (Unger 1950) from the exponent without memory; where it does not settle, the
        memory is brought in by steps.

        tolerance: of s, relative to w
        returns: s, q and whether it settled
        """
        for shares in ((1.0,), (0.25, 0.5, 0.75, 1.0)):
            here, mode, settled = s, q, True
            for share in shares:
                here, mode, settled = self._newton(here, mode, share, tolerance)
                if not settled:
                    break
            if settled:
                break
        return here, mode, settled

    def _newton(
        self, s: complex, q: Complex, share: float, tolerance: float, iterations: int = 12
    ) -> tuple[complex, Complex, bool]:
        """With P(share s) for P(s)."""
        by_s, constant = self._linear
        identity, small = np.eye(len(by_s)), 1e-5 * self.w
        q = q / np.linalg.norm(q)
        contact = self.contact_stiffness(share * s)
        slope = share * (self.contact_stiffness(share * s + small) - contact) / small
        for _ in range(iterations):
            value = s**2 * identity + s * by_s + constant + contact
            u = np.linalg.solve(value, (2 * s * identity + by_s + slope) @ q)
            change = complex(np.vdot(q, q) / np.vdot(q, u))
            s, q = s - change, np.asarray(u / np.linalg.norm(u), dtype=np.complex128)
            if not np.isfinite(s) or abs(s.real) > self.w:
                break
            if abs(change) < tolerance * self.w:
                return s, q, True
            before, contact = contact, self.contact_stiffness(share * s)
            slope = (before - contact) / change
        return s, q, False

    def harmonic_shares(self, q: Complex) -> Floats:
        """(2 order + 1, n) share of each harmonic -order..order in modes (m c, n)."""
        c = self.harmonics.n_coefficients
        parts = q.reshape(-1, c, q.shape[-1])
        shares = np.zeros((2 * self.order + 1, q.shape[-1]))
        shares[self.order] = (np.abs(parts[:, 0]) ** 2).sum(axis=0)
        for k in range(1, self.order + 1):
            cosine, sine = parts[:, 2 * k - 1], parts[:, 2 * k]
            shares[self.order + k] = (np.abs(cosine - 1j * sine) ** 2).sum(axis=0) / 4
            shares[self.order - k] = (np.abs(cosine + 1j * sine) ** 2).sum(axis=0) / 4
        return shares / shares.sum(axis=0)

    def floquet(self, values: Complex, vectors: Complex) -> tuple[Complex, Complex]:
        """The 2 m exponents whose modes are the most symmetric in their harmonics (Lazarus and Thomas 2010; Guillot
        et al. 2020): every exponent s comes with copies s + i k w, shifted by k harmonics and truncated.

        returns: sorted by falling real part
        """
        mean = np.arange(-self.order, self.order + 1) @ self.harmonic_shares(vectors)
        kept = np.argsort(np.abs(mean), kind="stable")[: 2 * len(self.damping)]
        kept = kept[np.argsort(-values[kept].real)]
        return values[kept], vectors[:, kept]


def _without_residual(loads: Complex, onto: Complex, rows: Integers) -> Complex:
    """(1 + T R)^-1 T phi on the rows where T is not zero: (n, c, m, c) from T phi and T R (n, c, n, c)."""
    size = len(rows) * loads.shape[1]
    reduced = np.zeros_like(loads)
    if not size:
        return reduced
    matrix = np.eye(size) + onto[rows][:, :, rows].reshape(size, size)
    right = loads[rows].reshape(size, -1)
    reduced[rows] = scipy.linalg.solve(matrix, right, check_finite=False).reshape(loads[rows].shape)
    return reduced
