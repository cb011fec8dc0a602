"""A damper whose force grows with a power of the velocity."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.memoryless import Sampled

Floats = NDArray[np.float64]
# Share of the reference velocity below which a velocity is rounded off: so small that no force changes by it, so large
# that a damper at rest has a derivative whatever its exponent.
_AT_REST = 1e-12


class PowerLawParameters(NamedTuple):
    """force: at the reference velocity, 0 or more [N]; exponent: p, 1 or more [-]"""

    force: jax.Array
    exponent: jax.Array


@dataclass(frozen=True)
class PowerLawDamper:
    """f = force |v / reference|^p sign(v). At amplitude A and angular frequency w it takes

        force A (w A / reference)^p 2 sqrt(pi) Gamma(p/2 + 1) / Gamma(p/2 + 3/2)

    a cycle: pi force A (w A / reference) at p = 1, a dashpot's, and 8/3 force A (w A / reference)^2 at p = 2.

    reference: velocity at which the force is stated [m/s]

    raises: ValueError for a reference velocity that is not positive
    """

    reference: float
    parameters: ClassVar[type] = PowerLawParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True
    at_least: ClassVar[Mapping[str, float]] = {"force": 0.0, "exponent": 1.0}

    def __post_init__(self) -> None:
        if not 0 < self.reference < np.inf:
            raise ValueError(f"PowerLawDamper: reference = {self.reference:g} m/s must be positive")

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: PowerLawParameters) -> jax.Array:
        relative = velocity / self.reference
        size = jnp.sqrt(relative**2 + _AT_REST**2)
        return parameters.force * relative * size ** (parameters.exponent - 1)

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        relative, further = velocity / self.reference, parameters.exponent - 1
        squared = relative**2 + _AT_REST**2
        power = squared ** (further / 2)
        # of relative power(relative)
        slope = power * (1 + further * relative**2 / squared)
        return Sampled(parameters.force * relative * power, by_velocity=parameters.force * slope / self.reference)

    def reference_stiffness(self, parameters: PowerLawParameters) -> jax.Array:
        return jnp.zeros(1)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Where its force is 0 it is its reference spring, which has no stiffness, however it moves."""
        return np.asarray(parameters.force == 0)
