"""Two uncoupled Jenkins elements (t1, t2) and a unilateral normal spring: the law of Pesaresi et al. 2017."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from updamp.hbm.contact import friction, sticking
from updamp.hbm.contact.compiled.shared import SLIDER_STANDS
from updamp.hbm.contact.event_march import march_slider
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.friction_contact import FrictionContact
from updamp.hbm.contact.law import CompiledForces
from updamp.hbm.contact.parameter_moves import friction_derivatives
from updamp.hbm.harmonics import Harmonics


def _moves(tangential: jax.Array, displacement: jax.Array, p: FrictionParameters) -> jax.Array:
    """(n_time,) whether a slider moves before or after each sample. The force alone does not tell: one that slipped on
    its way to the settled motion is at its limit for an instant of every period since, and stands.
    """
    surface = displacement[:, :2]
    slider = surface - tangential / p.kt
    after = jnp.any(
        jnp.abs(jnp.roll(slider, -1, axis=0) - slider) > SLIDER_STANDS * jnp.abs(surface).max(axis=0), axis=1
    )
    return after | jnp.roll(after, 1)


@dataclass(frozen=True)
class JenkinsBox(FrictionContact):
    """cycles: hysteresis cycles marched; this law settles in exactly two."""

    cycles: int = 2
    settles_in: ClassVar[int] = 2
    decoupled_directions: ClassVar[tuple[int, ...]] = (0, 1)
    divides_by: ClassVar[tuple[str, ...]] = ("kn",)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        tangential = march_slider(displacement, parameters, self.cycles).tangential
        return friction.beyond_rest(tangential, displacement, parameters)

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        """As `force`, with what happens between the samples shared between them."""
        rest = jnp.concatenate([parameters.t0, friction.rest_normal_force(parameters)[None]])
        return march_slider(displacement, parameters, self.cycles).averaged - rest

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces:
        from updamp.hbm.contact.compiled.box_forces import between_samples

        return between_samples(self.cycles, harmonics, n_time)

    surely_sticks = staticmethod(sticking.within_box)
    parameter_derivatives = staticmethod(friction_derivatives)

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        tangential = march_slider(displacement, parameters, self.cycles).tangential
        return friction.state(displacement, parameters, _moves(tangential, displacement, parameters))
