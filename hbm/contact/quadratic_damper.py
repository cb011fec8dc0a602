"""A damper whose force grows with the square of the velocity."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp


class QuadraticDamperParameters(NamedTuple):
    """coefficient: force = coefficient |v| v [N s^2/m^2]"""

    coefficient: jax.Array


@dataclass(frozen=True)
class QuadraticDamper:
    """f = coefficient |v| v: at amplitude A and angular frequency w it takes 8/3 coefficient w^2 A^3 a cycle, as a
    viscous damper of 8/(3 pi) coefficient w A does.
    """

    parameters: ClassVar[type] = QuadraticDamperParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: QuadraticDamperParameters) -> jax.Array:
        return parameters.coefficient * jnp.abs(velocity) * velocity

    def reference_stiffness(self, parameters: QuadraticDamperParameters) -> jax.Array:
        return jnp.zeros(1)
