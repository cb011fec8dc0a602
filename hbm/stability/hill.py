"""Hill's eigenproblem of a periodic response: exponents s of perturbations e^(s t) p(t) (Hill 1886; Groll and Ewins
2001 for the harmonic balance), in the slow modes of the stuck structure.

    L(s) q = (s + w D)^2 q + C (s + w D) q + Omega^2 q + P(s) q = 0,   D the derivative with respect to w t
    P(s) = phi^T (1 + T(s) R)^-1 T(s) phi

T(s) are the contacts' departures from stuck, R the flexibility of all that has no mass here. Structural (hysteretic)
damping is taken as the viscous damping that equals it at each mode's own frequency.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.condensed_structure import CondensedStructure, condense
from updamp.hbm.stability.contact_tangent import ContactTangent, LooseElements, loose_elements

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

BEYOND = 3.0  # times the highest harmonic: slower modes keep their mass
# Mean harmonic about which modes are symmetric. About 0 itself the copies at +i w/2 and -i w/2 of an exponent of period
# doubling have means -1/2 and +1/2: of two such exponents both copies of one, and none of the other, could be taken.
CENTRE = -0.05  # any small shift tells the two apart: to this side, the one at +i w/2 is kept
LARGE = 1500  # unknown forces: from there on factors are of single precision


@dataclass(frozen=True, eq=False)
class HillProblem:
    """x: (n_relative, n_coefficients) [m] in the system's harmonics; w [rad/s]; perturbations: harmonics 0..order

    kept: the structure to take; None for one of this problem's own
    """

    system: NonlinearSystem
    x: Floats
    w: float
    order: int
    time_samples: int
    kept: CondensedStructure | None = None

    @cached_property
    def harmonics(self) -> Harmonics:
        return Harmonics(tuple(range(self.order + 1)))

    @cached_property
    def loose(self) -> tuple[LooseElements, ...]:
        x = self.system.harmonics.change_to(self.harmonics, self.x)
        return loose_elements(self.system, x, self.w, self.harmonics, self.time_samples)

    def tangent(self, s: complex) -> ContactTangent:
        n = self.system.stuck.n_relative
        return ContactTangent.at(self.loose, n, self.w, s, self.harmonics, self.time_samples)

    @cached_property
    def still(self) -> ContactTangent:
        """At s = 0, that of the harmonic balance"""
        return self.tangent(0.0)

    @cached_property
    def n_forces(self) -> int:
        """Unknown forces: active rows times coefficients"""
        return len(self.still.rows) * self.harmonics.n_coefficients

    @cached_property
    def structure(self) -> CondensedStructure:
        if self.kept is not None:
            return self.kept
        return condense(self.system.stuck, self.still.mean(), BEYOND * self.order * self.w)

    @cached_property
    def derivative(self) -> Floats:
        """(n_coefficients, n_coefficients) of the coefficients with respect to w t"""
        matrix = np.zeros((self.harmonics.n_coefficients,) * 2)
        for k, place in self.harmonics.slices.items():
            if k:
                matrix[place, place] = [[0, k], [-k, 0]]
        return matrix

    @cached_property
    def linear(self) -> tuple[Floats, Floats]:
        """Factors of s and of 1 in L(s), contacts stuck: (m c, m c), ordered (mode, coefficient)."""
        structure, w = self.structure, self.w
        identity, modes = np.eye(self.harmonics.n_coefficients), np.eye(len(structure))
        by_s = 2 * w * np.kron(modes, self.derivative) + np.kron(structure.damping, identity)
        constant = (
            w**2 * np.kron(modes, self.derivative @ self.derivative)
            + w * np.kron(structure.damping, self.derivative)
            + np.kron(np.diag(structure.omega_squared), identity)
        )
        return by_s, constant

    @cached_property
    def contact(self) -> Floats:
        """P(0): (m c, m c) [1/s^2]"""
        return self._contact_and_sign[0]

    @cached_property
    def determinant_sign(self) -> float:
        """Of L(0), flexibility included: that of the Jacobian. Where it is -1 an odd number of real exponents grows,
        since L is positive for large s.
        """
        return self._contact_and_sign[1] * float(np.linalg.slogdet(self.linear[1] + self.contact)[0])

    @cached_property
    def _contact_and_sign(self) -> tuple[Floats, float]:
        return _condensed(self.structure, self.still, self.harmonics.n_coefficients, np.float64)

    def contact_at(self, s: complex) -> Complex:
        """P(s): (m c, m c) [1/s^2]. raises: scipy.linalg.LinAlgError"""
        tangent, c = self.tangent(s), self.harmonics.n_coefficients
        kind = np.complex64 if self.n_forces > LARGE else np.complex128
        return np.asarray(_condensed(self.structure, tangent, c, kind)[0], dtype=np.complex128)

    def eigen(self, contact: Floats | Complex) -> tuple[Complex, Complex]:
        """All exponents [1/s] and their modes (m c, n), where P(s) is `contact` for all s."""
        by_s, constant = self.linear
        size = len(by_s)
        companion = np.block([[np.zeros((size, size)), np.eye(size)], [-(constant + contact), -by_s]])
        values, vectors = scipy.linalg.eig(companion, check_finite=False)
        return values, vectors[:size].astype(np.complex128)


def symmetric_exponents(problem: HillProblem) -> Complex:
    """(2 m,) by falling real part [1/s]: those of the response, where contacts answer to all perturbations alike.

    Of all copies s + i k w, shifted by k harmonics and truncated, they are the ones whose modes are the most symmetric
    in their harmonics (Lazarus and Thomas 2010; Guillot et al. 2020): the copies of one exponent have their means a
    harmonic apart, so that an interval of length 1 about `CENTRE` has one of each.
    """
    values, vectors = problem.eigen(problem.contact)
    mean = np.arange(-problem.order, problem.order + 1) @ _harmonic_shares(problem, vectors)
    kept = np.argsort(np.abs(mean - CENTRE), kind="stable")[: 2 * len(problem.structure)]
    return values[kept][np.argsort(-values[kept].real)]


def _harmonic_shares(problem: HillProblem, q: Complex) -> Floats:
    """(2 order + 1, n) share of each harmonic -order..order in modes (m c, n)."""
    order = problem.order
    parts = q.reshape(-1, problem.harmonics.n_coefficients, q.shape[-1])
    shares = np.zeros((2 * order + 1, q.shape[-1]))
    shares[order] = (np.abs(parts[:, 0]) ** 2).sum(axis=0)
    for k in range(1, order + 1):
        cosine, sine = parts[:, 2 * k - 1], parts[:, 2 * k]
        shares[order + k] = (np.abs(cosine - 1j * sine) ** 2).sum(axis=0) / 4
        shares[order - k] = (np.abs(cosine + 1j * sine) ** 2).sum(axis=0) / 4
    return shares / shares.sum(axis=0)


def _condensed(
    structure: CondensedStructure, tangent: ContactTangent, c: int, kind: type[np.generic]
) -> tuple[NDArray[Any], float]:
    """P, and for real numbers the sign of det(1 + T R).

    kind: of numbers. Single precision, which halves the time, is made good by one correction.
    """
    m, rows, sign = len(structure), tangent.rows, 1.0
    if not len(rows):
        return np.zeros((m * c, m * c)), sign
    motion = (structure.phi[:, None, :, None] * np.eye(c)[:, None, :]).reshape(-1, c, m * c)
    loads: NDArray[Any] = tangent.apply(motion)
    if not np.issubdtype(kind, np.complexfloating):
        loads = loads.real
    if structure.flexibility.any():
        matrix = tangent.onto(structure.flexibility, kind)
        matrix[np.diag_indices_from(matrix)] += 1
        factors = scipy.linalg.lu_factor(matrix, overwrite_a=True, check_finite=False)
        if kind is np.float64:
            swaps = np.count_nonzero(factors[1] != np.arange(len(matrix)))
            sign = float(np.prod(np.sign(np.diagonal(factors[0]))) * (-1) ** swaps)
        right = loads[rows].reshape(len(matrix), -1)
        forces = scipy.linalg.lu_solve(factors, right.astype(kind), check_finite=False).astype(right.dtype)
        if kind is np.complex64:
            moved = (structure.flexibility[:, rows] @ forces.reshape(len(rows), -1)).reshape(-1, c, m * c)
            left = right - forces - tangent.apply(moved)[rows].reshape(right.shape)
            forces += scipy.linalg.lu_solve(factors, left.astype(kind), check_finite=False)
        loads[rows] = forces.reshape(loads[rows].shape)
    return np.tensordot(structure.phi.T, loads, axes=1).reshape(m * c, m * c), sign
