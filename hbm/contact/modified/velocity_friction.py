"""Friction that falls with the sliding speed."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.varying_friction import VaryingFriction
from updamp.hbm.contact.law import CompiledFriction, CompiledRateForces, compiled_forces_of
from updamp.hbm.contact.modified.modified_law import LawArguments, ModifiedLaw, sticks_with_friction
from updamp.hbm.harmonics import Harmonics

# The corner of |v| at rest is rounded over this share of the reference speed.
_ROUNDED = 0.01


@dataclass(frozen=True)
class VelocityFriction(ModifiedLaw):
    """The inner law with mu (1 - d v / (v + v0)), v the size of the tangential relative velocity of both surfaces.

    Parameters velocity_drop d [-] below 1 and reference_speed v0 [m/s], at which half of the drop is reached.
    """

    rank: ClassVar[int] = 20
    entries: ClassVar[tuple[str, ...]] = ("velocity_drop", "reference_speed")

    @property
    def rate_dependent(self) -> bool:
        return True

    def inner_arguments(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> LawArguments:
        p = parameters
        corner = _ROUNDED * p.reference_speed
        speed = jnp.sqrt(velocity[:, 0] ** 2 + velocity[:, 1] ** 2 + corner**2) - corner
        factor = 1 - p.velocity_drop * speed / (speed + p.reference_speed)
        return displacement, velocity, p._replace(mu=p.mu * factor)

    def compiled_rate(self, harmonics: Harmonics, n_time: int) -> CompiledRateForces | None:
        inner = compiled_forces_of(self.inner, harmonics, n_time)
        if not isinstance(inner, CompiledFriction):
            return None
        return VaryingFriction(inner, friction_at, np.ascontiguousarray(harmonics.synthesis_rate(n_time).T))

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """With the least friction that any speed leaves, where the inner law can tell."""
        least = parameters.mu * np.minimum(1.0, 1 - np.asarray(parameters.velocity_drop))
        return sticks_with_friction(self.inner, least, displacement, parameters, overshoot)


def friction_at(velocity: NDArray[np.float64], parameters: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, n_time) mu, and (n, 2, n_time) its derivative by the tangential velocity (n, 2, n_time) [m/s]: as
    `VelocityFriction.inner_arguments` has it."""
    mu, drop, reference = (
        np.asarray(value)[:, None] for value in (parameters.mu, parameters.velocity_drop, parameters.reference_speed)
    )
    corner = _ROUNDED * reference
    rounded = np.sqrt(np.sum(velocity**2, axis=1) + corner**2)
    speed = rounded - corner
    by_speed = -mu * drop * reference / (speed + reference) ** 2
    return mu * (1 - drop * speed / (speed + reference)), (by_speed / rounded)[:, None] * velocity
