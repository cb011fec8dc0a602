"""Nonlinear springs without history: of the second, third and fifth power, and unilateral with a gap."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.memoryless import Sampled

Floats = NDArray[np.float64]


class CubicParameters(NamedTuple):
    """coefficient: force = coefficient u^3 [N/m^3]"""

    coefficient: jax.Array


@dataclass(frozen=True)
class CubicSpring:
    parameters: ClassVar[type] = CubicParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: CubicParameters) -> jax.Array:
        return parameters.coefficient * displacement**3

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        k, u = parameters.coefficient, displacement
        return Sampled(k * u**3, 3 * k * u**2)

    def reference_stiffness(self, parameters: CubicParameters) -> jax.Array:
        return jnp.zeros(1)

    def surely_sticks(
        self, displacement: NDArray[np.float64], parameters: CubicParameters, overshoot: float
    ) -> NDArray[np.bool_]:
        """Where its coefficient is 0 it is its reference spring, which has no stiffness, however it moves."""
        return np.asarray(parameters.coefficient == 0)


@dataclass(frozen=True)
class SquareSpring(CubicSpring):
    """force = coefficient |u| u [N/m^2]"""

    surely_sticks = CubicSpring.surely_sticks

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: CubicParameters) -> jax.Array:
        return parameters.coefficient * jnp.abs(displacement) * displacement

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        k, size = parameters.coefficient, np.abs(displacement)
        return Sampled(k * size * displacement, 2 * k * size)


@dataclass(frozen=True)
class QuinticSpring(CubicSpring):
    """force = coefficient u^5 [N/m^5]"""

    surely_sticks = CubicSpring.surely_sticks

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: CubicParameters) -> jax.Array:
        return parameters.coefficient * displacement**5

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        k, squared = parameters.coefficient, displacement**2
        return Sampled(k * squared**2 * displacement, 5 * k * squared**2)


class UnilateralParameters(NamedTuple):
    """stiffness [N/m]; gap: opening before contact [m]"""

    stiffness: jax.Array
    gap: jax.Array


@dataclass(frozen=True)
class UnilateralSpring:
    """Contact counts from the next sample on, as other codes have it: coefficients jump with the amplitude, and a curve
    has dozens of small folds where a sample comes into contact. `stops.Stop` is the same spring without them."""

    parameters: ClassVar[type] = UnilateralParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: UnilateralParameters) -> jax.Array:
        return parameters.stiffness * jnp.maximum(displacement - parameters.gap, 0.0)

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        k, beyond = parameters.stiffness, np.maximum(displacement - parameters.gap, 0.0)
        return Sampled(k * beyond, k * (beyond > 0))

    def one_sided(self, parameters: Any) -> NDArray[np.bool_]:
        """(n_elements,) where it pushes one way alone from rest on; with a negative gap it is pressed at rest."""
        return (np.asarray(parameters.stiffness) != 0) & (np.asarray(parameters.gap) >= 0)

    def reference_stiffness(self, parameters: UnilateralParameters) -> jax.Array:
        return jnp.zeros(1)
