"""What the friction laws with a slider and a unilateral normal spring share: parameters, the march of the slider
through cycles of a periodic motion, and what is read off it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.law import SEPARATED, SLIP, STICK


def last_cycle(
    step: Callable[[jax.Array, Any], tuple[jax.Array, Any]], start: jax.Array, samples: Any, cycles: int
) -> Any:
    """Scan `step(history, sample) -> (history, output)` over `cycles` periods of `samples`; outputs of the last."""
    history = start
    for _ in range(cycles - 1):
        history, _ = jax.lax.scan(lambda h, s: (step(h, s)[0], None), history, samples)
    return jax.lax.scan(step, history, samples)[1]


Return = Callable[[jax.Array, jax.Array], jax.Array]


class FrictionParameters(NamedTuple):
    """One entry an element.

    mu: coefficient of friction [-]
    kt, kn: tangential and normal stiffness [N/m]
    n0: preload [N]; may be 0
    t0: (2,) tangential force at rest along (t1, t2) [N]
    gap: opening at rest [m]
    """

    mu: jax.Array
    kt: jax.Array
    kn: jax.Array
    n0: jax.Array
    t0: jax.Array
    gap: jax.Array


def normal_force(displacement: jax.Array, p: FrictionParameters) -> jax.Array:
    """Unilateral spring with preload: N = max(N0 + kn (u_n - gap), 0)."""
    return jnp.maximum(p.n0 + p.kn * (displacement[..., 2] - p.gap), 0.0)


def tangential_force(displacement: jax.Array, p: FrictionParameters, return_map: Return, cycles: int) -> jax.Array:
    """(n_time, 2) force of the slider behind the spring kt, starting from the force t0 at rest."""
    limit = slip_limit(displacement, p)

    def step(slider: jax.Array, sample: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        tangential, bound = sample
        force = return_map(p.kt * (tangential - slider), bound)
        return tangential - force / p.kt, force

    return last_cycle(step, -p.t0 / p.kt, (displacement[:, :2], limit), cycles)


def dynamic_force(displacement: jax.Array, p: FrictionParameters, return_map: Return, cycles: int) -> jax.Array:
    """(n_time, 3) force less that at rest: preload is a state, not a force."""
    return beyond_rest(tangential_force(displacement, p, return_map, cycles), displacement, p)


def beyond_rest(tangential: jax.Array, displacement: jax.Array, p: FrictionParameters) -> jax.Array:
    """(n_time, 3) from the total tangential force (n_time, 2)."""
    normal = normal_force(displacement, p) - rest_normal_force(p)
    return jnp.concatenate([tangential - p.t0, normal[:, None]], axis=1)


def rest_normal_force(p: FrictionParameters) -> jax.Array:
    return jnp.maximum(p.n0 - p.kn * p.gap, 0.0)


def state(displacement: jax.Array, p: FrictionParameters, slipping: jax.Array) -> jax.Array:
    """(n_time,) STICK, SLIP or SEPARATED; slipping: (n_time,)"""
    return jnp.where(normal_force(displacement, p) <= 0.0, SEPARATED, jnp.where(slipping, SLIP, STICK))


def slip_limit(displacement: jax.Array, p: FrictionParameters) -> jax.Array:
    """(n_time,) mu N [N]"""
    return p.mu * normal_force(displacement, p)


def stuck_stiffness(p: FrictionParameters) -> jax.Array:
    return jnp.stack([p.kt, p.kt, p.kn])
