"""What the friction laws have in common, whatever the slip limit holds of the tangential force."""

from typing import ClassVar

import jax

from updamp.hbm.contact import friction
from updamp.hbm.contact.friction import FrictionParameters


class FrictionContact:
    """A slider behind the spring kt in (t1, t2), and a normal spring that can only press.

    What follows from the force itself each law states beside it (`law.is_of_its_force`).
    """

    parameters: ClassVar[type] = FrictionParameters
    directions: ClassVar[int] = 3
    rate_dependent: ClassVar[bool] = False

    def reference_stiffness(self, parameters: FrictionParameters) -> jax.Array:
        return friction.stuck_stiffness(parameters)

    def normal_force(self, displacement: jax.Array, velocity: jax.Array, parameters: FrictionParameters) -> jax.Array:
        return friction.normal_force(displacement, parameters)
