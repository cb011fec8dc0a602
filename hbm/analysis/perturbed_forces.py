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

from updamp.hbm.contact.law import ContactLaw, force_for_analysis
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SETTLING = 2  # periods marched before the one looked at; the box law forgets in one


def has_memory(law: ContactLaw) -> bool:
    """Laws with a slider march it through `cycles` periods; the others have none."""
    return hasattr(law, "cycles")


def perturbed_tangent(
    group: ElementGroup, displacement: Floats, w: float, s: complex, harmonics: Harmonics, n_time: int
) -> Complex:
    """Coefficients of e^(-s t) df for the perturbation e^(s t) p(t), p given by its coefficients.

    displacement: (n_elements, directions, n_coefficients) of the periodic motion [m]; w [rad/s]; s [1/s]
    returns: (n_elements, directions, n_coefficients, directions, n_coefficients) [N/m]; at s = 0 the tangent of
    `element_forces`
    """
    tangent = _compiled(group.law, harmonics, n_time)(displacement, w, s.real, s.imag, group.parameters)
    return np.asarray(tangent)


@lru_cache(maxsize=16)
def _compiled(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Any:
    memory = has_memory(law)
    # After the period looked at there is one more: what is between its last sample and the next belongs to it.
    periods = getattr(law, "cycles", 1) + SETTLING + 1 if memory else 1
    looked_at = slice(-2 * n_time, -n_time) if memory else slice(None)
    once: Any = dataclasses.replace(law, cycles=1) if memory else law  # type: ignore[type-var]
    force_samples = force_for_analysis(once)
    basis = np.tile(harmonics.synthesis(n_time), (periods, 1))
    rate = np.tile(harmonics.synthesis_rate(n_time), (periods, 1))
    before = looked_at.indices(periods * n_time)[0]
    since = 2 * np.pi * (np.arange(periods * n_time) - before) / n_time  # w t, 0 at the start of the period looked at
    analysis = harmonics.analysis(n_time)

    def one(coefficients: jax.Array, w: jax.Array, real: jax.Array, imag: jax.Array, parameters: Any) -> jax.Array:
        s, directions = real + 1j * imag, coefficients.shape[0]
        growth = jnp.exp(s * since / w)
        motion = growth[:, None] * basis
        speed = growth[:, None] * (s * basis + w * rate)

        def force(u: jax.Array, v: jax.Array) -> jax.Array:
            one_period: jax.Array = force_samples(u, v, parameters)[looked_at]
            return one_period

        def along(i: jax.Array, u: jax.Array, v: jax.Array) -> jax.Array:
            where = jnp.zeros(directions).at[i].set(1.0)
            point = (basis @ coefficients.T, w * (rate @ coefficients.T))
            return jax.jvp(force, point, (u[:, None] * where, v[:, None] * where))[1]

        def column(i: jax.Array, b: jax.Array) -> jax.Array:
            u, v = motion[:, b], speed[:, b]
            answer = along(i, u.real, v.real) + 1j * along(i, u.imag, v.imag)
            return jnp.matmul(analysis, answer / growth[looked_at, None]).T  # (directions, n_coefficients)

        each = jax.vmap(jax.vmap(column, in_axes=(None, 0)), in_axes=(0, None))
        columns: jax.Array = each(jnp.arange(directions), jnp.arange(basis.shape[1]))  # (e, b, d, a)
        return columns.transpose(2, 3, 0, 1)

    return jax.jit(jax.vmap(one, in_axes=(0, None, None, None, 0)))
