"""Dampers at two places whose loss grows with each place's own amplitude, and differs in phase and out of phase."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp


class PairedAmplitudeDamperParameters(NamedTuple):
    """in_phase, out_of_phase: force over |u| and that part of the velocities [N s/m^2]"""

    in_phase: jax.Array
    out_of_phase: jax.Array


@dataclass(frozen=True)
class PairedAmplitudeDamper:
    """f_1 = |u_1| (a (v_1 + v_2) / 2 + b (v_1 - v_2) / 2), f_2 = |u_2| (a (v_1 + v_2) / 2 - b (v_1 - v_2) / 2), u
    counted from the mean: a in phase, b out of phase. With a = b these are two dampers f = a |u| v.

    Two equal bodies have other shapes where they move together than where they move against each other, and so another
    loss for the same amplitudes of these places.
    """

    parameters: ClassVar[type] = PairedAmplitudeDamperParameters
    directions: ClassVar[int] = 2
    rate_dependent: ClassVar[bool] = True

    def force(
        self, displacement: jax.Array, velocity: jax.Array, parameters: PairedAmplitudeDamperParameters
    ) -> jax.Array:
        vibration = displacement - jnp.mean(displacement, axis=0)
        together = parameters.in_phase * (velocity[:, 0] + velocity[:, 1]) / 2
        against = parameters.out_of_phase * (velocity[:, 0] - velocity[:, 1]) / 2
        return jnp.abs(vibration) * jnp.stack([together + against, together - against], axis=1)

    def reference_stiffness(self, parameters: PairedAmplitudeDamperParameters) -> jax.Array:
        return jnp.zeros(2)
