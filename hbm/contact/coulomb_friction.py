"""Dry friction whose force is the same however fast it slides: Coulomb's law on a motion that never rests."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.dry_friction import DryFriction, DryFrictionParameters

# m/s: slower than anything that is measured; at rest there is to be a derivative.
_AT_REST = 1e-12


@dataclass(frozen=True)
class CoulombFriction:
    """f = force sign(v), its jump at rest rounded over a share of the period's own velocity, so that amplitude and
    frequency alone decide nothing: the loss factor that it makes goes with one over the amplitude, whatever that is.

    At amplitude A it takes 4 force A a cycle, less the pi^2 / 24 part of the squared share.

    share: of the velocity's amplitude, below which it resists as a dashpot
    """

    share: float = 0.05
    parameters: ClassVar[type] = DryFrictionParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: DryFrictionParameters) -> jax.Array:
        return self._rounded(velocity).force(displacement, velocity, parameters)

    def averaged_force(
        self, displacement: jax.Array, velocity: jax.Array, parameters: DryFrictionParameters
    ) -> jax.Array:
        """What it does between samples too (`DryFriction.averaged_force`)."""
        return self._rounded(velocity).averaged_force(displacement, velocity, parameters)

    def _rounded(self, velocity: jax.Array) -> DryFriction:
        amplitude = jnp.sqrt(2 * jnp.mean(velocity**2) + _AT_REST**2)
        return DryFriction(self.share * amplitude)  # type: ignore[arg-type]  # traced

    def reference_stiffness(self, parameters: DryFrictionParameters) -> jax.Array:
        return jnp.zeros(1)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Where its force is 0 it is its reference spring, which has no stiffness, however it moves."""
        return np.asarray(parameters.force == 0)
