"""What a joint loses once it slides as a whole: a Jenkins element, less the stiffness that it has while it sticks:
that is in the modes that were identified."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.friction import last_cycle


class SlidingParameters(NamedTuple):
    """lost: stiffness of the joint, gone while it slides [N/m]; slip: displacement at which it begins to [m], its slip
    force over that stiffness"""

    lost: jax.Array
    slip: jax.Array


@dataclass(frozen=True)
class SlidingJoint:
    """f = k (e - u), k the joint's stiffness, e the displacement u less what has slid, |e| <= slip: nothing until it
    slides, then the stiffness is gone and there is a loop, of an area of 4 k slip (A - slip) at amplitude A
    (J. H. Griffin, J. Eng. Power 102 (1980) 329). By the displacement rather than by the force, so that a joint
    without stiffness is a joint too.

    cycles: marched until the history has settled
    """

    cycles: int = 2
    settles_in: ClassVar[int] = 2
    parameters: ClassVar[type] = SlidingParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False
    at_least: ClassVar[Mapping[str, float]] = {"lost": 0.0}
    above: ClassVar[Mapping[str, float]] = {"slip": 0.0}

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: SlidingParameters) -> jax.Array:
        lost, slip = parameters

        def step(slid: jax.Array, u: jax.Array) -> tuple[jax.Array, jax.Array]:
            elastic = jnp.clip(u - slid, -slip, slip)
            return u - elastic, elastic

        elastic = last_cycle(step, jnp.zeros(1), displacement, self.cycles)
        return lost * (elastic - displacement)

    def reference_stiffness(self, parameters: SlidingParameters) -> jax.Array:
        return jnp.zeros(1)
