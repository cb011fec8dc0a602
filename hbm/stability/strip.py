"""Exponents of contacts with memory, each in its copy with 0 <= Im s <= w/2.

P(s) is computed at a few s = i nu w and interpolated between them: over that strip it changes smoothly, by e^(-s tau)
with delays tau below a period. The copy near s = 0 sees the same harmonics as the harmonic balance itself.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.stability.hill import HillProblem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

NODES = (0.0, 0.25, 0.5)  # nu. Without 0.25 the slope of P at 0 is wrong, and with it exponents near 0
FASTEST = 0.1  # of w: those that decay faster are not looked at; those that grow faster are with P where they are
MARGIN = 0.02  # of w, beyond the strip
ITERATIONS = 12  # of Newton's method
MOVED = 0.002  # of w: exponents that a correction moves further are corrected once more,
CORRECTIONS = 4  # so many times


@dataclass(frozen=True, eq=False)
class Exponent:
    """s [1/s] and its mode q (m c,)"""

    s: complex
    q: Complex


@dataclass(frozen=True, eq=False)
class Strip:
    """contacts: P(s) at s = i nu w, nu those of `nodes`; tolerance: of an exponent, relative to w"""

    problem: HillProblem
    nodes: tuple[float, ...]
    contacts: tuple[Complex, ...]
    tolerance: float

    @staticmethod
    def of(problem: HillProblem, tolerance: float) -> "Strip":
        """raises: scipy.linalg.LinAlgError where a matrix is singular"""
        still = problem.contact.astype(np.complex128)
        others = tuple(problem.contact_at(1j * nu * problem.w) for nu in NODES[1:])
        return Strip(problem, NODES, (still, *others), tolerance)

    @cached_property
    def _places(self) -> tuple[Floats, Complex]:
        """nu, negative ones included, where P is the complex conjugate."""
        mirrored = [(-nu, P.conj()) for nu, P in zip(self.nodes, self.contacts, strict=True) if nu]
        both = [*zip(self.nodes, self.contacts, strict=True), *mirrored]
        return np.array([nu for nu, _ in both]), np.array([P for _, P in both])

    def contact(self, s: complex) -> Complex:
        """P(s) between the nodes (Lagrange)."""
        nu, P = self._places
        z = s / (1j * self.problem.w)
        weights = [np.prod([(z - b) / (a - b) for b in nu if b != a]) for a in nu]
        return np.tensordot(np.array(weights), P, axes=1)

    def exponents(self) -> tuple[list[Exponent], float]:
        """All in the strip that settle and do not decay faster than it reaches, by falling real part; and the largest
        real part of those that do not settle."""
        w, half = self.problem.w, 0.6 * (self.nodes[1] - self.nodes[0])
        found: list[Exponent] = []
        lost = -np.inf
        for nu, P in zip(self.nodes, self.contacts, strict=True):
            values, vectors = self.problem.eigen(P)
            near = (np.abs(values.imag / w - nu) < half) & (values.real > -FASTEST * w)
            for i in np.flatnonzero(near & (values.imag > -MARGIN * w) & (values.imag < (0.5 + MARGIN) * w)):
                start = Exponent(complex(values[i]), vectors[:, i])
                one = self._from(start)
                if one is None:
                    lost = max(lost, start.s.real)
                elif one.s.real > -FASTEST * w and all(abs(one.s - o.s) > 10 * self.tolerance * w for o in found):
                    found.append(one)
        return sorted(found, key=lambda one: -one.s.real), lost

    def _from(self, start: Exponent) -> Exponent | None:
        """The exponent that one with the P of a node leads to, where it settles. What grows fast is far from all nodes,
        and P is computed where it is."""
        one: Exponent | None = start
        if start.s.real < FASTEST * self.problem.w:
            one = self._settled(start, 0.0) or self._settled_by_eigenvalues(start)
        if one is not None and one.s.real >= FASTEST * self.problem.w:
            return self.corrected(one, self.problem)
        return one

    def corrected(self, one: Exponent, problem: HillProblem) -> Exponent | None:
        """The exponent with the P of `problem`, of the same harmonics and modes; None where it does not settle.

        P is computed where the exponent is, again and again until it stays there: what moves on is none.
        """
        here = one
        for _ in range(CORRECTIONS):
            again = self._settled(here, problem.contact_at(here.s) - self.contact(here.s))
            if again is None or abs(again.s - here.s) < MOVED * self.problem.w:
                return again
            here = again
        return None

    def _settled_by_eigenvalues(self, one: Exponent) -> Exponent | None:
        """For those that Newton's method loses: the eigenvalue nearest to s, with P at s, again and again."""
        s, w = one.s, self.problem.w
        for _ in range(ITERATIONS):
            values, vectors = self.problem.eigen(self.contact(s))
            nearest = int(np.argmin(np.abs(values - s)))
            change, s = abs(values[nearest] - s), complex(values[nearest])
            if abs(s.real) > w:
                return None
            if change < 1e-3 * w:
                return self._settled(Exponent(s, vectors[:, nearest]), 0.0)
        return None

    def _settled(self, one: Exponent, correction: Complex | float) -> Exponent | None:
        """Newton's method on L(s) q = 0 (Unger 1950), from there on with Im s >= 0."""
        by_s, constant = self.problem.linear
        s, q, w = one.s, one.q, self.problem.w
        identity, small = np.eye(len(by_s)), 1e-4 * w
        for _ in range(ITERATIONS):
            contact = self.contact(s)
            slope = (self.contact(s + small) - contact) / small
            value = s**2 * identity + s * by_s + constant + contact + correction
            u = np.linalg.solve(value, (2 * s * identity + by_s + slope) @ q)
            change = complex(np.vdot(q, q) / np.vdot(q, u))
            s, q = s - change, np.asarray(u / np.linalg.norm(u))
            if not np.isfinite(s) or abs(s.real) > w:
                return None
            if abs(change) < self.tolerance * w:
                return Exponent(s, q) if s.imag >= 0 else Exponent(s.conjugate(), q.conj())
        return None
