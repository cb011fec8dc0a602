"""A viscous film in the contact."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.film_forces import FilmForces
from updamp.hbm.contact.law import CompiledRateForces, ContactLaw, decoupled_directions_of
from updamp.hbm.contact.modified.modified_law import ModifiedLaw, compression, extended_type, rest_compression
from updamp.hbm.harmonics import Harmonics


@dataclass(frozen=True)
class ViscousFilm(ModifiedLaw):
    """The inner law and a dashpot in all three directions for as long as the contact is closed.

    Parameter viscosity [N s/m].
    """

    rank: ClassVar[int] = 80
    entries: ClassVar[tuple[str, ...]] = ("viscosity",)

    @property
    def rate_dependent(self) -> bool:
        return True

    @property
    def decoupled_directions(self) -> tuple[int, ...]:
        return decoupled_directions_of(self.inner)

    def outer_force(self, force: jax.Array, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return force + FilmForce(self.inner).force(displacement, velocity, parameters)

    @property
    def parts(self) -> tuple[ContactLaw, ...]:
        return self.inner, FilmForce(self.inner)


@dataclass(frozen=True)
class FilmForce:
    """The dashpots alone. inner: the law that tells when the contact is closed"""

    inner: Any
    directions: ClassVar[int] = 3
    decoupled_directions: ClassVar[tuple[int, ...]] = (0, 1)
    rate_dependent: ClassVar[bool] = True

    @property
    def parameters(self) -> type:
        return extended_type(self.inner.parameters, ViscousFilm.entries)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        closed = closed_share(compression(self.inner, displacement, velocity, parameters))
        viscous: jax.Array = parameters.viscosity * velocity * closed[:, None]
        return viscous

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        return jnp.zeros(3)

    def rest_compression(self, parameters: Any) -> NDArray[np.float64]:
        """(n_elements,) see `modified_law.rest_compression` [m]"""
        return rest_compression(self.inner, parameters)

    def compiled_rate(self, harmonics: Harmonics, n_time: int) -> CompiledRateForces:
        return FilmForces(self, harmonics, n_time)


def closed_share(compression: jax.Array) -> jax.Array:
    """(n_time,) share of the time from half a sample before to half a sample after that the contact is closed.

    On straight lines between the samples, so that the force does not jump when an opening moves past a sample.
    """
    before = (jnp.roll(compression, 1) + compression) / 2
    after = (jnp.roll(compression, -1) + compression) / 2
    return (_share_above_zero(before, compression) + _share_above_zero(compression, after)) / 2


def _share_above_zero(a: jax.Array, b: jax.Array) -> jax.Array:
    """Of a straight line from a to b."""
    high, low = jnp.maximum(a, b), jnp.minimum(a, b)
    crosses = (high > 0) & (low < 0)
    return jnp.where(crosses, high / jnp.where(crosses, high - low, 1.0), jnp.where(high > 0, 1.0, 0.0))
