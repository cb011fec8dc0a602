"""A damper whose loss factor grows with the amplitude."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp


class AmplitudeDamperParameters(NamedTuple):
    """coefficient: force = coefficient |u| v [N s/m^2]"""

    coefficient: jax.Array


@dataclass(frozen=True)
class AmplitudeDamper:
    """f = coefficient |u| v, u counted from the mean: at amplitude A and angular frequency w it takes
    4/3 coefficient w A^3 a cycle, which over the energy of a spring is a loss factor in proportion to A.
    """

    parameters: ClassVar[type] = AmplitudeDamperParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: AmplitudeDamperParameters) -> jax.Array:
        vibration = displacement - jnp.mean(displacement, axis=0)
        return parameters.coefficient * jnp.abs(vibration) * velocity

    def reference_stiffness(self, parameters: AmplitudeDamperParameters) -> jax.Array:  # noqa: ARG002
        return jnp.zeros(1)
