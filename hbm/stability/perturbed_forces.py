"""How contact forces answer a perturbation that grows or decays from period to period, history included.

About a periodic motion x(t) the perturbation is e^(s t) p(t), p periodic. A law with a slider answers to what the
slider went through in the periods before, which were smaller (or larger) by e^(-s T): its tangent depends on s, and
the tangent of the harmonic balance is that at s = 0 only. With it Hill's method is right about turning points and
wrong, at leading order, about how fast anything decays.
"""

import dataclasses
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, decoupled_directions_of, force_for_analysis
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, compiled_hysteresis
from updamp.hbm.problem.laws_in_jax import elements_a_batch

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

SETTLING = 2  # periods marched before the one looked at; the box law forgets in one


def depends_on_growth(law: ContactLaw) -> bool:
    """Whether the tangent depends on s: of laws with a slider, marched through `cycles`, and rate-dependent ones."""
    return hasattr(law, "cycles") or law.rate_dependent


def perturbed_tangent(
    group: ElementGroup,
    displacement: Floats,
    w: float,
    s: complex,
    harmonics: Harmonics,
    n_time: int,
    numbers: Integers | None = None,
) -> Complex:
    """Coefficients of e^(-s t) df for the perturbation e^(s t) p(t), p given by its coefficients.

    displacement: (n_elements, directions, n_coefficients) of the periodic motion [m]; w [rad/s]; s [1/s]
    numbers: (n,) of the elements wanted; all where None
    returns: (n, directions, n_coefficients, directions, n_coefficients) [N/m], of one of the copies that an element
    stands for; at s = 0 the tangent of `element_forces`
    """
    numbers = np.arange(len(displacement)) if numbers is None else numbers
    if (forces := compiled_hysteresis(group.law, harmonics, n_time)) is not None:
        written = np.empty((*displacement.shape, *displacement.shape[1:]), dtype=np.complex128)
        forces.write_perturbed_tangents(numbers, displacement, group.values, s / w, written)
        return np.asarray(written[numbers])
    return in_jax(group, displacement, w, s, harmonics, n_time, numbers)


def in_jax(
    group: ElementGroup,
    displacement: Floats,
    w: float,
    s: complex,
    harmonics: Harmonics,
    n_time: int,
    numbers: Integers,
) -> Complex:
    """For laws that are not written out for numba, and as what these are checked against."""
    size = len(displacement[0].ravel())
    tangent = np.zeros((len(numbers), *displacement.shape[1:], *displacement.shape[1:]), dtype=np.complex128)
    batch = min(elements_a_batch(2 * size), len(displacement))
    evaluate = _compiled(group.law, harmonics, n_time)
    for start in range(0, len(numbers), batch):
        some = np.resize(numbers[start : start + batch], batch)  # filled up, so that a law is compiled once
        parameters = type(group.values)(*(value[some] for value in group.values))
        found = np.asarray(evaluate(displacement[some], w, s.real, s.imag, parameters))
        tangent[start : start + batch] = found[: len(numbers) - start]
    return tangent


@lru_cache(maxsize=16)
def _compiled(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Any:
    memory = hasattr(law, "cycles")
    # After the period looked at there is one more: what is between its last sample and the next belongs to it.
    periods = getattr(law, "cycles", 1) + SETTLING + 1 if memory else 1
    looked_at = slice(-2 * n_time, -n_time) if memory else slice(None)
    once: Any = dataclasses.replace(law, cycles=1) if memory else law  # type: ignore[type-var]
    force_samples = force_for_analysis(once)
    basis = np.tile(harmonics.synthesis(n_time), (periods, 1))
    rate = np.tile(harmonics.synthesis_rate(n_time), (periods, 1))
    before = looked_at.indices(periods * n_time)[0]
    since = 2 * np.pi * (np.arange(periods * n_time) - before) / n_time  # w t, 0 at the start of the period looked at
    analysis, patterns = harmonics.analysis(n_time), _patterns(law)

    def one(coefficients: jax.Array, w: jax.Array, real: jax.Array, imag: jax.Array, parameters: Any) -> jax.Array:
        s = real + 1j * imag
        growth = jnp.exp(s * since / w)
        motion = growth[:, None] * basis
        speed = growth[:, None] * (s * basis + w * rate)
        point = (basis @ coefficients.T, w * (rate @ coefficients.T))

        def force(u: jax.Array, v: jax.Array) -> jax.Array:
            one_period: jax.Array = force_samples(u, v, parameters)[looked_at]
            return one_period

        def along(u: jax.Array, v: jax.Array) -> jax.Array:
            return jax.jvp(force, point, (u, v))[1]

        def column(pattern: jax.Array, b: jax.Array) -> jax.Array:
            u, v = motion[:, b, None] * pattern, speed[:, b, None] * pattern
            answer = along(u.real, v.real) + 1j * along(u.imag, v.imag)
            return jnp.matmul(analysis, answer / growth[looked_at, None]).T  # (directions, n_coefficients)

        each = jax.vmap(jax.vmap(column, in_axes=(None, 0)), in_axes=(0, None))
        return _by_direction(law, each(patterns, jnp.arange(basis.shape[1])))

    return jax.jit(jax.vmap(one, in_axes=(0, None, None, None, 0)))


def _patterns(law: ContactLaw) -> jax.Array:
    """(n, directions) directions moved together: all decoupled ones, and each of the others."""
    decoupled = decoupled_directions_of(law)
    together = [np.isin(np.arange(law.directions), decoupled).astype(float)] if decoupled else []
    return jnp.array([*together, *(np.eye(law.directions)[d] for d in range(law.directions) if d not in decoupled)])


def _by_direction(law: ContactLaw, columns: jax.Array) -> jax.Array:
    """(patterns, b, directions, a) -> (directions, a, directions, b): what moved together is told apart again."""
    decoupled = decoupled_directions_of(law)
    others = [d for d in range(law.directions) if d not in decoupled]
    blocks = columns.transpose(0, 2, 3, 1)  # (patterns, directions, a, b)
    tangent = jnp.zeros((blocks.shape[1], blocks.shape[2], law.directions, blocks.shape[3]), dtype=columns.dtype)
    for d in decoupled:
        tangent = tangent.at[d, :, d].set(blocks[0, d])
    for place, d in enumerate(others, start=1 if decoupled else 0):
        tangent = tangent.at[:, :, d].set(blocks[place])
    return tangent
