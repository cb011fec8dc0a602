"""Derivatives of a friction law's forces by its parameters, from its tangent: what a parameter does, a motion does too.

A slider behind a spring is a play operator, of one direction or of two, and the normal spring is one-sided. Of these
    F_t(u) / kt = Phi(u, mu kn p / kt, -t0 / kt)   forces at rest included; p = u_n + n0 / kn - gap the compression
depends on the motion u, the slip limit and where the slider starts. Phi does not change where motion and start are
shifted alike, and is homogeneous of degree one in all three (Euler): so the derivatives by mu, kt, kn, n0, t0 and gap
are those along certain motions. Exact for whatever is marched, at samples or between them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.law import (
    ContactLaw,
    LawAt,
    LawOfMoves,
    compiled_forces_of,
    is_of_its_force,
)

Floats = NDArray[np.float64]

_Change = Callable[[Floats, FrictionParameters, int], tuple[Floats, Floats]]


def derivatives_of(law: ContactLaw, entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
    """df/d(entry) of any law: entry -> (n_elements, directions, n_coefficients, *shape of the entry of one element)

    returns: None of a law whose tangent does not tell
    """
    if isinstance(law, LawOfMoves) and is_of_its_force(law, "parameter_derivatives"):
        return law.parameter_derivatives(entries, at)
    return None


def with_own_tangent(law: ContactLaw, at: LawAt) -> LawAt | None:
    """The same motion with the tangent of this law; None where it is in JAX alone."""
    compiled = compiled_forces_of(law, at.harmonics, at.n_time)
    if compiled is None:
        return None
    numbers, x, tangent = np.arange(len(at.displacement)), at.displacement, np.empty_like(at.tangent)
    compiled.write_with_tangents(numbers, x, at.w, at.parameters, np.empty_like(x), tangent, np.zeros_like(x))
    return replace(at, tangent=tangent)


def friction_derivatives(entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
    """Of a law with `FrictionParameters`; mu may vary over the period, (n_elements, n_time), where it is not asked for.

    returns: None where one of the mu is 0: without a limit no motion does what friction does
    """
    p = at.parameters
    if "mu" in entries and not np.all(p.mu):
        return None
    n, d, c = at.displacement.shape
    square, found = at.tangent.reshape(n, d * c, d * c), {}
    for entry in entries:
        motion, held = _CHANGES[entry](at.displacement, p, at.mean)
        found[entry] = (square @ motion.reshape(n, d * c, -1)).reshape(motion.shape) + held
        if entry == "mu":  # the compression's change is that of the limit alone
            found[entry][:, 2] = 0.0
    return found


def _by_mu(displacement: Floats, p: FrictionParameters, mean: int) -> tuple[Floats, Floats]:
    """As the limit grows in proportion, so it does with the compression."""
    motion = np.zeros_like(displacement)
    motion[:, 2] = displacement[:, 2]
    motion[:, 2, mean] += p.n0 / p.kn - p.gap
    return motion / p.mu[:, None, None], np.zeros_like(displacement)


def _by_kt(displacement: Floats, p: FrictionParameters, _mean: int) -> tuple[Floats, Floats]:
    """f_t = kt Phi - t0, of which limit and start go with 1 / kt: what is left of kt Phi is the part of the motion."""
    motion = displacement / p.kt[:, None, None]
    motion[:, 2] = 0.0
    return motion, np.zeros_like(displacement)


def _by_kn(displacement: Floats, p: FrictionParameters, mean: int) -> tuple[Floats, Floats]:
    """kn p = kn (u_n - gap) + n0, less its value at rest."""
    motion, held = np.zeros_like(displacement), np.zeros_like(displacement)
    motion[:, 2] = displacement[:, 2]
    motion[:, 2, mean] -= p.gap
    held[:, 2, mean] = p.gap * _presses_at_rest(p)
    return motion / p.kn[:, None, None], held


def _by_n0(displacement: Floats, p: FrictionParameters, mean: int) -> tuple[Floats, Floats]:
    motion, held = np.zeros_like(displacement), np.zeros_like(displacement)
    motion[:, 2, mean] = 1 / p.kn
    held[:, 2, mean] = -_presses_at_rest(p)
    return motion, held


def _by_gap(displacement: Floats, p: FrictionParameters, mean: int) -> tuple[Floats, Floats]:
    motion, held = np.zeros_like(displacement), np.zeros_like(displacement)
    motion[:, 2, mean] = -1.0
    held[:, 2, mean] = p.kn * _presses_at_rest(p)
    return motion, held


def _by_t0(displacement: Floats, p: FrictionParameters, mean: int) -> tuple[Floats, Floats]:
    """A slider that starts elsewhere sees the motion shifted."""
    motion, held = np.zeros((*displacement.shape, 2)), np.zeros((*displacement.shape, 2))
    for direction in range(2):
        motion[:, direction, mean, direction] = 1 / p.kt
        held[:, direction, mean, direction] = -1.0
    return motion, held


def _presses_at_rest(p: FrictionParameters) -> Floats:
    """Derivative of the normal force at rest by n0; the mean of both sides where it is 0, as JAX has it."""
    return np.heaviside(p.n0 - p.kn * p.gap, 0.5)


_CHANGES: dict[str, _Change] = {
    "mu": _by_mu, "kt": _by_kt, "kn": _by_kn, "n0": _by_n0, "gap": _by_gap, "t0": _by_t0,
}  # fmt: skip
