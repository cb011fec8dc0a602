"""One Jenkins element with a constant slip force: spring kt in series with a slider that gives way at +-limit."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.friction import last_cycle


class JenkinsParameters(NamedTuple):
    """kt: stiffness [N/m]; limit: slip force [N]"""

    kt: jax.Array
    limit: jax.Array


@dataclass(frozen=True)
class Jenkins:
    cycles: int = 2
    settles_in: ClassVar[int] = 2
    parameters: ClassVar[type] = JenkinsParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: JenkinsParameters) -> jax.Array:
        kt, limit = parameters

        def step(slider: jax.Array, u: jax.Array) -> tuple[jax.Array, jax.Array]:
            force = jnp.clip(kt * (u - slider), -limit, limit)
            return u - force / kt, force

        return last_cycle(step, jnp.zeros(1), displacement, self.cycles)

    def reference_stiffness(self, parameters: JenkinsParameters) -> jax.Array:
        return jnp.reshape(parameters.kt, (1,))
