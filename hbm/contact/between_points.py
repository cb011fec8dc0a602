"""A law of one direction between two places, in place of one place and the ground."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, as_sticking_law, force_for_analysis
from updamp.hbm.contact.one_sided import OneSidedLaw


@dataclass(frozen=True)
class BetweenPoints:
    """The inner law sees the first place's motion less the second one's; its force acts on both, in opposite
    directions.

    inner: of one direction and without reference stiffness, which would couple both places
    """

    inner: ContactLaw
    directions: ClassVar[int] = 2

    @property
    def parameters(self) -> type:
        return self.inner.parameters

    @property
    def rate_dependent(self) -> bool:
        return self.inner.rate_dependent

    @property
    def at_least(self) -> Mapping[str, float]:
        """As the inner law has it, for hbm/problem/element_checks.py."""
        return dict(getattr(self.inner, "at_least", {}))

    @property
    def above(self) -> Mapping[str, float]:
        """As the inner law has it."""
        return dict(getattr(self.inner, "above", {}))

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return _on_both(self.inner.force(_across(displacement), _across(velocity), parameters))

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return _on_both(force_for_analysis(self.inner)(_across(displacement), _across(velocity), parameters))

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        return jnp.zeros(2)

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        if (inner := as_sticking_law(self.inner)) is None:
            return np.zeros(len(displacement), dtype=bool)
        return inner.surely_sticks(displacement[:, :1] - displacement[:, 1:], parameters, overshoot)

    def one_sided(self, parameters: Any) -> NDArray[np.bool_]:
        if isinstance(self.inner, OneSidedLaw):
            return self.inner.one_sided(parameters)
        return np.zeros(len(parameters[0]), dtype=bool)


def _across(motion: jax.Array) -> jax.Array:
    """(n_time, 2) -> (n_time, 1)"""
    return motion[:, :1] - motion[:, 1:]


def _on_both(force: jax.Array) -> jax.Array:
    """(n_time, 1) -> (n_time, 2)"""
    return jnp.concatenate([force, -force], axis=1)
