"""Contacts that see only a share of the mean motion."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp

from updamp.hbm.contact.compiled.composed import RateShareOfMean, ShareOfMean
from updamp.hbm.contact.law import (
    CompiledForces,
    CompiledRateForces,
    compiled_forces_of,
    compiled_rate_forces_of,
    decoupled_directions_of,
)
from updamp.hbm.contact.modified.modified_law import LawArguments, ModifiedLaw
from updamp.hbm.harmonics import Harmonics


@dataclass(frozen=True)
class StaticShare(ModifiedLaw):
    """The inner law at u - (1 - c) mean(u).

    Parameter static_share c [-]: 1 for the law as it is, 0 for contacts that do not notice where the mean goes.
    """

    rank: ClassVar[int] = 100
    entries: ClassVar[tuple[str, ...]] = ("static_share",)

    @property
    def decoupled_directions(self) -> tuple[int, ...]:
        return decoupled_directions_of(self.inner)

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        inner = compiled_forces_of(self.inner, harmonics, n_time)
        return None if inner is None else ShareOfMean(inner, harmonics.slices.get(0, slice(0)))

    def compiled_rate(self, harmonics: Harmonics, n_time: int) -> CompiledRateForces | None:
        inner = compiled_rate_forces_of(self.inner, harmonics, n_time)
        return None if inner is None else RateShareOfMean(inner, harmonics.slices.get(0, slice(0)))

    def inner_arguments(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> LawArguments:
        unseen = (1 - parameters.static_share) * jnp.mean(displacement, axis=0)
        return displacement - unseen, velocity, parameters
