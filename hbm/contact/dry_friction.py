"""Dry friction that has no stick left: its force depends on the velocity alone."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

# Between two samples the force turns round within a few thousandths of a period: places that it is looked at there.
_BETWEEN = 8


class DryFrictionParameters(NamedTuple):
    """force: while it slides, 0 or more [N]"""

    force: jax.Array


class RoundedFriction(ABC):
    """f = force tanh(v / creep): Coulomb's law with its jump at rest rounded, and linear in the force."""

    parameters: ClassVar[type] = DryFrictionParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True
    at_least: ClassVar[Mapping[str, float]] = {"force": 0.0}

    @abstractmethod
    def creep_of(self, velocity: jax.Array) -> jax.Array | float:
        """Velocity below which it resists as a dashpot of force / creep does [m/s]; of a period's samples."""

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: DryFrictionParameters) -> jax.Array:
        return parameters.force * jnp.tanh(velocity / self.creep_of(velocity))

    def averaged_force(
        self, displacement: jax.Array, velocity: jax.Array, parameters: DryFrictionParameters
    ) -> jax.Array:
        """What the force does between samples beyond a straight line, the velocity on one, is shared between its
        neighbours like the load on a beam: it turns round faster than samples follow each other.
        """
        creep = self.creep_of(velocity)
        after = jnp.roll(velocity, -1, axis=0)
        here, there = (jnp.tanh(v / creep) for v in (velocity, after))
        own, next_one = jnp.zeros_like(here), jnp.zeros_like(here)
        for s in (np.arange(_BETWEEN) + 0.5) / _BETWEEN:
            beyond = jnp.tanh(((1 - s) * velocity + s * after) / creep) - ((1 - s) * here + s * there)
            own, next_one = own + (1 - s) / _BETWEEN * beyond, next_one + s / _BETWEEN * beyond
        return parameters.force * (here + own + jnp.roll(next_one, 1, axis=0))

    def reference_stiffness(self, parameters: DryFrictionParameters) -> jax.Array:
        return jnp.zeros(1)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Where its force is 0 it is its reference spring, which has no stiffness, however it moves."""
        return np.asarray(parameters.force == 0)


@dataclass(frozen=True)
class DryFriction(RoundedFriction):
    """Rounded over a velocity of its own.

    At amplitude A and angular frequency w it takes 4 force A a cycle, less a share of pi^2 / 24 (creep / (w A))^2
    where the motion is fast.

    creep: velocity below which it resists as a dashpot of force / creep does [m/s]

    raises: ValueError for a creep that is not positive
    """

    creep: float

    def __post_init__(self) -> None:
        if not 0 < self.creep < np.inf:
            raise ValueError(
                f"DryFriction: creep = {self.creep:g} m/s must be positive; well below the velocities of the motion it "
                "comes near to Coulomb's law"
            )

    def creep_of(self, velocity: jax.Array) -> float:
        return self.creep
