"""Coupled Coulomb friction: the tangential force stays within the circle mu N; unilateral normal spring."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from updamp.hbm.contact import friction, sticking
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.friction_contact import FrictionContact
from updamp.hbm.contact.parameter_moves import friction_derivatives


def radial_return(trial: jax.Array, limit: jax.Array) -> jax.Array:
    """The trial force is drawn back to the circle along its radius; the inner where keeps the tangent finite at 0."""
    squared = trial[0] ** 2 + trial[1] ** 2
    outside = squared > limit**2
    size = jnp.sqrt(jnp.where(outside, squared, 1.0))
    return jnp.where(outside, limit / size, 1.0) * trial


def at_circle(force: jax.Array, limit: jax.Array) -> jax.Array:
    return jnp.hypot(force[:, 0], force[:, 1]) >= limit * (1 - 1e-12)


@dataclass(frozen=True)
class CoulombCircle(FrictionContact):
    """cycles: hysteresis cycles marched; this law settles gradually (9e-5 from two to three cycles)."""

    cycles: int = 3

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        return friction.dynamic_force(displacement, parameters, radial_return, self.cycles)

    surely_sticks = staticmethod(sticking.within_circle)
    parameter_derivatives = staticmethod(friction_derivatives)

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        tangential = friction.tangential_force(displacement, parameters, radial_return, self.cycles)
        limit = friction.slip_limit(displacement, parameters)
        return friction.state(displacement, parameters, at_circle(tangential, limit))
