"""Laws that are in JAX alone, compiled for many elements: their forces in the frequency domain, tangents, loops."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp

from updamp.hbm.contact.law import ContactLaw, decoupled_directions_of, force_for_analysis
from updamp.hbm.harmonics import Harmonics

# Sizes of the batches of elements, small enough for the processor's cache: directional derivatives in one batch,
# elements in one batch of other quantities.
DERIVATIVES_A_BATCH, QUANTITIES_A_BATCH = 168, 8


def elements_a_batch(derivatives_an_element: int) -> int:
    """At least one element, however many derivatives it has."""
    return max(1, DERIVATIVES_A_BATCH // derivatives_an_element)


def samples(coefficients: jax.Array, w: Any, harmonics: Harmonics, n_time: int) -> tuple[jax.Array, jax.Array]:
    """(..., directions, n_coefficients) -> displacement and velocity, each (..., n_time, directions)."""
    displacement: jax.Array = jnp.einsum("tc,...dc->...td", harmonics.synthesis(n_time), coefficients)
    velocity = w * jnp.einsum("tc,...dc->...td", harmonics.synthesis_rate(n_time), coefficients)
    return displacement, velocity


def _one_element(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Callable[..., jax.Array]:
    analysis, force_samples = harmonics.analysis(n_time), force_for_analysis(law)

    def force(coefficients: jax.Array, w: jax.Array, parameters: Any) -> jax.Array:
        displacement, velocity = samples(coefficients, w, harmonics, n_time)
        return jnp.matmul(analysis, force_samples(displacement, velocity, parameters)).T

    return force


@lru_cache(maxsize=32)
def compiled_force(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Callable[..., Any]:
    return jax.jit(jax.vmap(_one_element(law, harmonics, n_time), in_axes=(0, None, 0)))


@lru_cache(maxsize=64)
def compiled_reference_stiffness(law: ContactLaw) -> Callable[..., Any]:
    """Of all elements. Step by step each primitive would be dispatched, and compiled, by itself: 10 ms a group."""
    return jax.jit(jax.vmap(law.reference_stiffness))


@lru_cache(maxsize=32)
def compiled_quantity(
    quantity: Callable[[jax.Array, jax.Array, Any], jax.Array], harmonics: Harmonics, n_time: int
) -> Callable[..., Any]:
    def one(coefficients: jax.Array, w: jax.Array, parameters: Any) -> tuple[jax.Array, jax.Array]:
        motion, velocity = samples(coefficients, w, harmonics, n_time)
        return motion, quantity(motion, velocity, parameters)

    return jax.jit(in_batches(one, QUANTITIES_A_BATCH))


@lru_cache(maxsize=32)
def compiled_loop_areas(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Callable[..., Any]:
    def one(coefficients: jax.Array, w: jax.Array, parameters: Any) -> jax.Array:
        motion, velocity = samples(coefficients, w, harmonics, n_time)
        force = law.force(motion, velocity, parameters)
        return ((force + jnp.roll(force, -1, axis=0)) / 2 * (jnp.roll(motion, -1, axis=0) - motion)).sum()

    return jax.jit(in_batches(one, QUANTITIES_A_BATCH))


@lru_cache(maxsize=32)
def compiled_with_tangents(law: ContactLaw, harmonics: Harmonics, n_time: int) -> Callable[..., Any]:
    force = _one_element(law, harmonics, n_time)
    by_frequency = law.rate_dependent
    seeds = _seeds(law, harmonics)

    def with_tangents(coefficients: jax.Array, w: jax.Array, parameters: Any) -> tuple[jax.Array, jax.Array, jax.Array]:
        def along(dc: jax.Array, dw: jax.Array) -> tuple[jax.Array, jax.Array]:
            at = (coefficients, jnp.asarray(w, dtype=coefficients.dtype))
            return jax.jvp(lambda c, w: force(c, w, parameters), at, (dc, dw))

        # all derivatives in one pass: a law is compiled once for them, not once more for the frequency
        dc = jnp.concatenate([seeds, jnp.zeros_like(seeds[:1])]) if by_frequency else seeds
        dw = jnp.zeros(len(dc)).at[len(seeds) :].set(1.0)
        value, derivatives = jax.vmap(along, out_axes=(None, 0))(dc, dw)
        tangent = _sorted(law, derivatives[: len(seeds)])
        return value, tangent, derivatives[-1] if by_frequency else jnp.zeros(())

    return jax.jit(jax.vmap(with_tangents, in_axes=(0, None, 0)))


def _seeds(law: ContactLaw, harmonics: Harmonics) -> jax.Array:
    """(n, directions, n_coefficients) changes of the displacement that the tangent follows from: of all decoupled
    directions at once, of the others one by one.
    """
    each, decoupled = jnp.eye(law.directions), list(decoupled_directions_of(law))
    others = [d for d in range(law.directions) if d not in decoupled]
    patterns = [*([each[jnp.array(decoupled)].sum(axis=0)] if decoupled else []), *(each[d] for d in others)]
    unit = jnp.eye(harmonics.n_coefficients)
    return jnp.concatenate([pattern[:, None] * unit[:, None] for pattern in patterns])


@lru_cache(maxsize=64)
def n_seeds(law: ContactLaw, harmonics: Harmonics) -> int:
    decoupled = len(decoupled_directions_of(law))
    return (law.directions - decoupled + (decoupled > 0)) * harmonics.n_coefficients


def _sorted(law: ContactLaw, derivatives: jax.Array) -> jax.Array:
    """From the derivatives along `_seeds`, (n, directions, n_coefficients), to the element's tangent."""
    d, c = derivatives.shape[1:]
    blocks = jnp.moveaxis(derivatives.reshape(-1, c, d, c), 1, -1)  # (patterns, directions, c of force, c of motion)
    decoupled, tangent = list(decoupled_directions_of(law)), jnp.zeros((d, c, d, c))
    for direction in decoupled:
        tangent = tangent.at[direction, :, direction].set(blocks[0, direction])
    others = [direction for direction in range(d) if direction not in decoupled]
    for direction, block in zip(others, blocks[1 if decoupled else 0 :], strict=True):
        tangent = tangent.at[:, :, direction].set(block)
    return tangent


def in_batches(one: Callable[..., Any], batch: int) -> Callable[..., Any]:
    """`one(coefficients, w, parameters)` over all elements in batches small enough for the processor's cache: with
    tangents, all 146 at once take 3.6 times as long.
    """

    def each(coefficients: jax.Array, w: jax.Array, parameters: Any) -> Any:
        return jax.lax.map(lambda a: one(a[0], w, a[1]), (coefficients, parameters), batch_size=batch)

    return each
