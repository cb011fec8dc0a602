"""Motions between samples: the cubics through values and slopes (Hermite), all segments at once, for JAX.

`hbm/contact/compiled/cubic.py` has the same for numba.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from updamp.hbm.contact.compiled.shared import AT_ROOT, MOST_STEPS, WHOLE_END, WHOLE_START


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


def rises_through(c: Cubics, level: jax.Array, a: jax.Array, b: jax.Array, sought: jax.Array) -> jax.Array:
    """Where the cubics rise through a level between a, where they are not above, and b, where they are not below. Where
    they begin at the level, it depends on which way they go. sought: which of them are looked for, all until none moves
    """

    under, over = c.value(a) - level, c.value(b) - level
    between = (under < 0) & (over > 0)
    start = jnp.where(between, a - under * (b - a) / jnp.where(between, over - under, 1.0), (a + b) / 2)

    def step(state: _Search) -> _Search:
        rest, rate = c.value(state.t) - level, c.slope(state.t)
        low, high = jnp.where(rest > 0, state.low, state.t), jnp.where(rest > 0, state.t, state.high)
        further = jnp.where(rate > 0, state.t - rest / jnp.where(rate > 0, rate, 1.0), low)
        further = jnp.where((low < further) & (further < high), further, (low + high) / 2)
        moves = sought & (jnp.abs(further - state.t) >= AT_ROOT)
        return _Search(low, high, further, moves, state.steps + 1)

    def goes_on(state: _Search) -> jax.Array:
        return jnp.any(state.moves) & (state.steps < MOST_STEPS)

    at_start = (under >= 0) & (c.slope(a) >= 0)
    sought = sought & ~at_start
    found = jax.lax.while_loop(goes_on, step, _Search(a, b, start, sought, jnp.asarray(0))).t
    return jnp.where(at_start, a, found)


class _Search(NamedTuple):
    low: jax.Array
    high: jax.Array
    t: jax.Array
    moves: jax.Array
    steps: jax.Array


def averages_against_hats(n: int) -> np.ndarray:
    """(n // 2 + 1,) by what the integrals of a motion's cubics against the hats about the samples differ from the
    samples, for each harmonic."""
    x = 2 * np.pi * np.arange(n // 2 + 1) / n
    slope = (8 * np.sin(x) - np.sin(2 * x)) / 6  # of e^(i x t), over i, as in `through`
    values = WHOLE_START[0] + WHOLE_END[1] + (WHOLE_START[1] + WHOLE_END[0]) * np.cos(x)
    return np.asarray(values + (WHOLE_END[2] - WHOLE_START[3]) * np.sin(x) * slope)
