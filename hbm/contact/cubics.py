"""Motions between samples: the cubics through values and slopes (Hermite), all segments at once, for JAX.

`hbm/contact/compiled/cubic.py` has the same for numba.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

# Newton's method halves its bracket wherever it leaves it.
_STEPS = 50


class Cubics(NamedTuple):
    """Coefficients of 1, t, t^2 and t^3, each of any shape; a segment runs from t = 0 to 1."""

    c0: jax.Array
    c1: jax.Array
    c2: jax.Array
    c3: jax.Array

    def value(self, t: jax.Array) -> jax.Array:
        return self.c0 + t * (self.c1 + t * (self.c2 + t * self.c3))

    def slope(self, t: jax.Array) -> jax.Array:
        return self.c1 + t * (2 * self.c2 + 3 * t * self.c3)

    def of(self, numbers: jax.Array) -> "Cubics":
        return Cubics(*(c[numbers] for c in self))

    def times(self, factor: jax.Array | float) -> "Cubics":
        return Cubics(*(factor * c for c in self))

    def less(self, other: "Cubics") -> "Cubics":
        return Cubics(*(one - two for one, two in zip(self, other, strict=True)))

    def halves(self, a: jax.Array, b: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Integrals times 1 - t, and times t, from a to b."""
        total, moment = jnp.zeros(()), jnp.zeros(())
        for i, c in enumerate(self):
            total += c * (b ** (i + 1) - a ** (i + 1)) / (i + 1)
            moment += c * (b ** (i + 2) - a ** (i + 2)) / (i + 2)
        return total - moment, moment


def through(values: jax.Array) -> Cubics:
    """(n,) samples of a periodic motion -> from each sample to the next, with slopes of fourth order."""
    near = jnp.roll(values, -1) - jnp.roll(values, 1)
    far = jnp.roll(values, -2) - jnp.roll(values, 2)
    slope = (8 * near - far) / 12
    rise, after = jnp.roll(values, -1) - values, jnp.roll(slope, -1)
    return Cubics(values, slope, 3 * rise - 2 * slope - after, slope + after - 2 * rise)


def tops(c: Cubics, a: jax.Array, b: jax.Array) -> jax.Array:
    """Where the slope falls through zero between a, where it is positive, and b, where it is negative; -1 elsewhere."""
    slope, bend, third = c.slope(a), 2 * c.c2 + 6 * c.c3 * a, 3 * c.c3
    turns = (slope > 0) & (c.slope(b) < 0)
    # the root of slope + bend x + third x^2 at which it falls, written so that nothing cancels where third is small
    root = -bend + jnp.sqrt(jnp.maximum(bend**2 - 4 * third * slope, 0.0))
    return jnp.where(turns, jnp.clip(a + 2 * slope / jnp.where(turns, root, 1.0), a, b), -1.0)


def rises_through(c: Cubics, level: jax.Array, a: jax.Array, b: jax.Array) -> jax.Array:
    """Where the cubics rise through a level between a, where they are not above, and b, where they are not below. Where
    they begin at the level, it depends on which way they go.
    """

    def step(_: int, state: tuple[jax.Array, jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array, jax.Array]:
        low, high, t = state
        over, rate = c.value(t) - level, c.slope(t)
        low, high = jnp.where(over > 0, low, t), jnp.where(over > 0, t, high)
        further = jnp.where(rate > 0, t - over / jnp.where(rate > 0, rate, 1.0), low)
        return low, high, jnp.where((low < further) & (further < high), further, (low + high) / 2)

    found = jax.lax.fori_loop(0, _STEPS, step, (a, b, (a + b) / 2))[2]
    return jnp.where((c.value(a) >= level) & (c.slope(a) >= 0), a, found)


def averages_against_hats(n: int) -> np.ndarray:
    """(n // 2 + 1,) by what the integrals of a motion's cubics against the hats about the samples differ from the
    samples, for each harmonic."""
    x = 2 * np.pi * np.arange(n // 2 + 1) / n
    return 0.7 + 0.3 * np.cos(x) + np.sin(x) * (8 * np.sin(x) - np.sin(2 * x)) / 90
