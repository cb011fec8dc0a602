"""What is met, or lets go, beyond a gap: springs with a corner that branches are followed across."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.memoryless import Sampled
from updamp.hbm.contact.springs import UnilateralParameters, UnilateralSpring

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stop(UnilateralSpring):
    """A unilateral spring whose corner counts where it is, not at the next sample, so that the coefficients of its
    force bend with the amplitude and do not jump.

    At amplitude A beyond the gap a its first harmonic is k A (t - sin t cos t) / pi, cos t = a / A.
    """

    def averaged_force(
        self, displacement: jax.Array, velocity: jax.Array, parameters: UnilateralParameters
    ) -> jax.Array:
        return parameters.stiffness * _shared(displacement - parameters.gap)

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        return _shared_with_slopes(displacement - parameters.gap).times(parameters.stiffness)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Without stiffness it is its reference spring, which has none either, however it moves."""
        return np.asarray(parameters.stiffness == 0)


@dataclass(frozen=True)
class Clearance(Stop):
    """The same gap both ways: stiffness (u - gap) beyond it one way, stiffness (u + gap) the other way. Its first
    harmonic is twice that of a stop, and there is no mean force.

    A negative stiffness is that of something pressed that opens, and is missed from there on.
    """

    at_least: ClassVar[Mapping[str, float]] = {"gap": 0.0}
    surely_sticks = Stop.surely_sticks

    def one_sided(self, parameters: Any) -> NDArray[np.bool_]:
        return np.zeros(np.shape(parameters.gap), dtype=bool)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: UnilateralParameters) -> jax.Array:
        u, gap = displacement, parameters.gap
        return parameters.stiffness * (u - jnp.clip(u, -gap, gap))

    def averaged_force(
        self, displacement: jax.Array, velocity: jax.Array, parameters: UnilateralParameters
    ) -> jax.Array:
        beyond = _shared(displacement - parameters.gap) - _shared(-displacement - parameters.gap)
        return parameters.stiffness * beyond

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        n, ways = len(displacement), np.concatenate([displacement, -displacement])
        both = _shared_with_slopes(ways - np.tile(parameters.gap, (2, 1)))
        return both.of(slice(n)).plus(both.of(slice(n, None)).opposite_way()).times(parameters.stiffness)


def _shared(way: jax.Array) -> jax.Array:
    """max(way, 0), for Fourier coefficients: where the way, straight between two samples, comes to 0 between them, what
    that leaves off the straight line between the two forces, a triangle, is shared between them like the load on a
    beam.

    way: (n_time, 1) samples of a period
    """
    after = jnp.roll(way, -1, axis=0)
    crosses = way * after < 0
    place = jnp.where(crosses, way / jnp.where(crosses, way - after, 1.0), 0.0)
    here, there = jnp.maximum(way, 0.0), jnp.maximum(after, 0.0)
    missing = jnp.where(crosses, here * (1 - place) + there * place, 0.0)
    return here - missing * (2 - place) / 6 - jnp.roll(missing * (1 + place) / 6, 1, axis=0)


def _shared_with_slopes(way: Floats) -> Sampled:
    """As `_shared`, of ways (n_elements, n_time), with what they change at the sample, the one before and the one
    after."""
    after = np.roll(way, -1, axis=1)
    force, by_own = np.maximum(way, 0.0), (way > 0).astype(float)
    e, here = np.nonzero(way * after < 0)
    there = (here + 1) % way.shape[1]
    w, a = way[e, here], after[e, here]
    apart, sign = w - a, np.where(w > 0, -1.0, 1.0)
    place, missing = w / apart, sign * w * a / apart
    # what is left off, and its place, by the way here and there
    by_w, by_a = (sign * -((a / apart) ** 2), -a / apart**2), (sign * (w / apart) ** 2, w / apart**2)
    force[e, here] -= missing * (2 - place) / 6
    force[e, there] -= missing * (1 + place) / 6
    by_last, by_next = np.zeros_like(way), np.zeros_like(way)
    by_own[e, here] += (missing * by_w[1] - by_w[0] * (2 - place)) / 6
    by_next[e, here] = (missing * by_a[1] - by_a[0] * (2 - place)) / 6
    by_own[e, there] -= (missing * by_a[1] + by_a[0] * (1 + place)) / 6
    by_last[e, there] = -(missing * by_w[1] + by_w[0] * (1 + place)) / 6
    return Sampled(force, by_own, by_last=by_last, by_next=by_next)
