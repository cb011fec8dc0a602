"""A spring whose force grows with the square of the displacement, on both sides the same way."""

from dataclasses import dataclass
from typing import ClassVar

import jax.numpy as jnp

from updamp.hbm.contact.springs import CubicParameters


@dataclass(frozen=True)
class QuadraticSpring:
    """f = k x^2 / 2: about x = A cos w t its stiffness is k A cos w t."""

    parameters: ClassVar[type] = CubicParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement, _velocity, parameters):
        return parameters.coefficient * displacement**2 / 2

    def reference_stiffness(self, _parameters):
        return jnp.zeros(1)
