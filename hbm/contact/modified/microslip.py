"""Microslip inside one contact element: sliders side by side that give way one after the other (Iwan 1966)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.composed import MeanOfSliders
from updamp.hbm.contact.law import (
    CompiledForces,
    LawAt,
    compiled_forces_of,
    decoupled_directions_of,
    force_for_analysis,
)
from updamp.hbm.contact.modified.modified_law import ModifiedLaw, sticks_with_friction
from updamp.hbm.contact.parameter_moves import derivatives_of, with_own_tangent
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]

SLIDERS = 6


@dataclass(frozen=True)
class SubPatchMicroslip(ModifiedLaw):
    """The mean of inner laws whose friction coefficients are spread evenly over mu (1 - w) ... mu (1 + w).

    Each has the same share of the stiffness, so that stiffness and largest force stay what they are.

    Parameter limit_spread w [-] in [0, 1].
    """

    rank: ClassVar[int] = 40
    entries: ClassVar[tuple[str, ...]] = ("limit_spread",)

    @property
    def decoupled_directions(self) -> tuple[int, ...]:
        return decoupled_directions_of(self.inner)

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        inner = compiled_forces_of(self.inner, harmonics, n_time)
        return None if inner is None else self.mean_of(inner)

    @staticmethod
    def mean_of(one: CompiledForces) -> CompiledForces:
        """Of sliders of this spread, from the forces of one."""
        return MeanOfSliders(one, np.asarray(evenly(SLIDERS)))

    def parameter_derivatives(self, entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
        """The mean of those of the sliders, each by its own friction coefficient."""
        p, total = at.parameters, dict[str, Floats]()
        wanted = dict.fromkeys((*(entry for entry in entries if entry != "limit_spread"), "mu"))
        for factor in np.asarray(evenly(SLIDERS)):
            of_one = with_own_tangent(
                self.inner, replace(at, parameters=p._replace(mu=p.mu * (1 + p.limit_spread * factor)))
            )
            found = None if of_one is None else derivatives_of(self.inner, tuple(wanted), of_one)
            if found is None:
                return None
            by_mu = found["mu"]
            found["mu"] = by_mu * (1 + p.limit_spread * factor)[:, None, None]
            found["limit_spread"] = by_mu * (p.mu * factor)[:, None, None]
            total = {entry: total.get(entry, 0.0) + found[entry] / SLIDERS for entry in entries}
        return total

    def surely_sticks(self, displacement: NDArray[np.float64], parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """Where the weakest slider does and the inner law can tell: then all of them do."""
        weakest = 1 - np.asarray(parameters.limit_spread) * (1 - 1 / SLIDERS)
        return sticks_with_friction(self.inner, parameters.mu * weakest, displacement, parameters, overshoot)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return self._of_each(self.inner.force, displacement, velocity, parameters).mean(axis=0)

    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return self._of_each(force_for_analysis(self.inner), displacement, velocity, parameters).mean(axis=0)

    def state(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        """Slipping as soon as the weakest slider does; separation is the same for all."""
        return self._of_each(self.inner.state, displacement, velocity, parameters).max(axis=0)

    def _of_each(
        self, quantity: Callable[..., jax.Array], displacement: jax.Array, velocity: jax.Array, parameters: Any
    ) -> jax.Array:
        spread = 1 + parameters.limit_spread * evenly(SLIDERS)

        def one(factor: jax.Array) -> jax.Array:
            return quantity(displacement, velocity, parameters._replace(mu=parameters.mu * factor))

        values: jax.Array = jax.vmap(one)(spread)
        return values


def evenly(n: int) -> jax.Array:
    """(n,) middles of n equal parts of [-1, 1]."""
    return (2 * jnp.arange(n) + 1) / n - 1
