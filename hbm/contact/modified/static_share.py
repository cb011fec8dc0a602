"""Contacts that see only a share of the mean motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.composed import ShareOfMean
from updamp.hbm.contact.law import (
    CompiledForces,
    ContactLaw,
    LawAt,
    compiled_forces_of,
    decoupled_directions_of,
    parts_of,
)
from updamp.hbm.contact.modified.modified_law import LawArguments, ModifiedLaw
from updamp.hbm.contact.parameter_moves import derivatives_of
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]


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

    @property
    def parts(self) -> tuple[ContactLaw, ...]:
        """The same share seen by each of the laws that the inner one is the sum of; none where it is no sum."""
        return tuple(StaticShare(part) for part in parts_of(self.inner))

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        inner = compiled_forces_of(self.inner, harmonics, n_time)
        return None if inner is None else ShareOfMean(inner, harmonics.slices.get(0, slice(0)))

    def parameter_derivatives(self, entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
        """Those of the inner law at the motion that it sees; None where it sees nothing of the mean."""
        share, mean = at.parameters.static_share[:, None, None], at.mean
        if not np.all(share):
            return None
        seen, tangent = at.displacement.copy(), at.tangent.copy()
        seen[..., mean] *= share[..., 0]
        tangent[..., mean] /= share[..., None]
        inside = replace(at, displacement=seen, tangent=tangent)
        found = derivatives_of(self.inner, [entry for entry in entries if entry != "static_share"], inside)
        if found is not None and "static_share" in entries:
            found["static_share"] = np.einsum("edaf,ef->eda", tangent[..., mean], at.displacement[..., mean])
        return found

    def inner_arguments(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> LawArguments:
        unseen = (1 - parameters.static_share) * jnp.mean(displacement, axis=0)
        return displacement - unseen, velocity, parameters
