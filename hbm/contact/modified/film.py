"""A viscous film in the contact."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.film_forces import FilmForces
from updamp.hbm.contact.law import CompiledForces, ContactLaw, LawAt, decoupled_directions_of
from updamp.hbm.contact.modified.modified_law import ModifiedLaw, compression, extended_type, rest_compression
from updamp.hbm.contact.parameter_moves import derivatives_of
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]


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

    def parameter_derivatives(self, entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
        """Those of the inner law, and what changes the compression at rest opens and closes the film as well."""
        p, film = at.parameters, FilmForces(FilmForce(self.inner), at.harmonics, at.n_time)
        numbers, x, tangent = np.arange(len(at.displacement)), at.displacement, np.zeros_like(at.tangent)
        of_one, rate = np.zeros_like(x), np.zeros_like(x)
        film.write_with_tangents(numbers, x, at.w, p, of_one, tangent, rate)
        inside = replace(at, tangent=at.tangent - tangent)
        found = derivatives_of(self.inner, [entry for entry in entries if entry != "viscosity"], inside)
        if found is None:
            return None
        for entry, by in (("n0", 1 / p.kn), ("kn", -p.n0 / p.kn**2), ("gap", -np.ones_like(p.gap))):
            if entry in found:
                found[entry] += by[:, None, None] * tangent[:, :, :, 2, at.mean]
        if "viscosity" in entries:
            film.write_forces(numbers, x, at.w, p._replace(viscosity=np.ones_like(p.viscosity)), of_one)
            found["viscosity"] = of_one
        return found


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

    @property
    def cycles(self) -> int:
        return int(self.inner.cycles)

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        closed = closed_share(compression(self.inner, displacement, velocity, parameters))
        viscous: jax.Array = parameters.viscosity * velocity * closed[:, None]
        return viscous

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        return jnp.zeros(3)

    def rest_compression(self, parameters: Any) -> NDArray[np.float64]:
        """(n_elements,) see `modified_law.rest_compression` [m]"""
        return rest_compression(self.inner, parameters)

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces:
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
