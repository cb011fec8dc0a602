"""The law of `jenkins_box` with its events taken at the samples, as most codes have it: to compare with them."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from updamp.hbm.contact import friction, sticking
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.friction_contact import FrictionContact
from updamp.hbm.contact.law import CompiledForces
from updamp.hbm.contact.parameter_moves import friction_derivatives
from updamp.hbm.harmonics import Harmonics


def clip_each(trial: jax.Array, limit: jax.Array) -> jax.Array:
    """Each component is held within the limit: the box."""
    return jnp.clip(trial, -limit, limit)


def _at_limit(force: jax.Array, limit: jax.Array) -> jax.Array:
    return jnp.any(jnp.abs(force) >= limit[:, None] * (1 - 1e-12), axis=1)


@dataclass(frozen=True)
class SampledJenkinsBox(FrictionContact):
    """cycles: hysteresis cycles marched; this law settles in exactly two."""

    cycles: int = 2
    settles_in: ClassVar[int] = 2
    decoupled_directions: ClassVar[tuple[int, ...]] = (0, 1)
    divides_by: ClassVar[tuple[str, ...]] = ("kn",)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        return friction.dynamic_force(displacement, parameters, clip_each, self.cycles)

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces:
        from updamp.hbm.contact.compiled.box_forces import at_samples

        return at_samples(self.cycles, harmonics, n_time)

    surely_sticks = staticmethod(sticking.within_box)
    parameter_derivatives = staticmethod(friction_derivatives)

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        tangential = friction.tangential_force(displacement, parameters, clip_each, self.cycles)
        limit = friction.slip_limit(displacement, parameters)
        return friction.state(displacement, parameters, _at_limit(tangential, limit))
