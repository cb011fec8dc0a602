"""A damper that acts only beyond a displacement."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.memoryless import Sampled

Floats = NDArray[np.float64]


class ThresholdDamperParameters(NamedTuple):
    """dashpot: force over velocity far beyond the threshold [N s/m]; threshold: displacement below which there is none,
    above 0 [m]"""

    dashpot: jax.Array
    threshold: jax.Array


@dataclass(frozen=True)
class ThresholdDamper:
    """f = dashpot v max(0, 1 - threshold / |u|). At an amplitude A above the threshold a it takes

        4 dashpot w A^2 (t/2 - sin(2 t)/4 - a/A (artanh(sin t) - sin t)),   cos t = a/A

    a cycle, w the angular frequency; below it nothing.
    """

    parameters: ClassVar[type] = ThresholdDamperParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True
    above: ClassVar[Mapping[str, float]] = {"threshold": 0.0}

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: ThresholdDamperParameters) -> jax.Array:
        beyond = jnp.maximum(jnp.abs(displacement), parameters.threshold)
        return parameters.dashpot * velocity * (1 - parameters.threshold / beyond)

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        size, a = np.abs(displacement), parameters.threshold
        beyond = np.maximum(size, a)
        acting = parameters.dashpot * (1 - a / beyond)
        by_displacement = parameters.dashpot * velocity * np.where(size > a, a * np.sign(displacement) / beyond**2, 0.0)
        return Sampled(acting * velocity, by_displacement, acting)

    def reference_stiffness(self, parameters: ThresholdDamperParameters) -> jax.Array:
        return jnp.zeros(1)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Where it has no dashpot it is its reference spring, which has no stiffness, however it moves."""
        return np.asarray(parameters.dashpot == 0)
