"""Dry friction whose force is the same however fast it slides: Coulomb's law on a motion that never rests."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from updamp.hbm.contact.dry_friction import RoundedFriction

# m/s: slower than anything that is measured; at rest there is to be a derivative.
_AT_REST = 1e-12


@dataclass(frozen=True)
class CoulombFriction(RoundedFriction):
    """f = force sign(v), its jump at rest rounded over a share of the period's own velocity, so that amplitude and
    frequency alone decide nothing: the loss factor that it makes goes with one over the amplitude, whatever that is.

    At amplitude A it takes 4 force A a cycle, less the pi^2 / 24 part of the squared share.

    share: of the velocity's amplitude, below which it resists as a dashpot

    raises: ValueError for a share that is not positive
    """

    share: float = 0.05

    def __post_init__(self) -> None:
        if not 0 < self.share < np.inf:
            raise ValueError(f"CoulombFriction: share = {self.share:g} must be positive, such as 0.05")

    def creep_of(self, velocity: jax.Array) -> jax.Array:
        return self.share * jnp.sqrt(2 * jnp.mean(velocity**2) + _AT_REST**2)
