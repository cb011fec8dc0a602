"""Friction that falls with the sliding speed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.varying_friction import VaryingFriction
from updamp.hbm.contact.law import CompiledForces, CompiledFriction, LawAt, compiled_forces_of
from updamp.hbm.contact.modified.modified_law import LawArguments, ModifiedLaw, sticks_with_friction
from updamp.hbm.contact.parameter_moves import derivatives_of, with_own_tangent
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]

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

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        return self.of_friction(compiled_forces_of(self.inner, harmonics, n_time), harmonics, n_time)

    @staticmethod
    def of_friction(inner: CompiledForces | None, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        """Of friction that falls with the speed, from the forces of a law with any; None where they do not tell"""
        if not isinstance(inner, CompiledFriction):
            return None
        return VaryingFriction(inner, friction_at, np.ascontiguousarray(harmonics.synthesis_rate(n_time).T))

    def parameter_derivatives(self, entries: Sequence[str], at: LawAt) -> dict[str, Floats] | None:
        """Those of the inner law with friction as it varies here, and what changes that friction by how it acts."""
        inner, p = compiled_forces_of(self.inner, at.harmonics, at.n_time), at.parameters
        if not isinstance(inner, CompiledFriction):
            return None
        rates = np.ascontiguousarray(at.harmonics.synthesis_rate(at.n_time).T)
        mu, changes = friction_by_parameters(at.w * (at.displacement[:, :2] @ rates), p)
        inside = with_own_tangent(self.inner, replace(at, parameters=p._replace(mu=mu)))
        if inside is None:
            return None
        numbers, varying = np.arange(len(mu)), inside.parameters
        found = derivatives_of(self.inner, [entry for entry in entries if entry not in changes], inside)
        if found is not None and (of_friction := [entry for entry in entries if entry in changes]):
            rows = np.stack([changes[entry] for entry in of_friction], axis=2)
            by_row = inner.by_friction(numbers, at.displacement, varying, rows)
            for i, entry in enumerate(of_friction):
                found[entry] = np.zeros_like(at.displacement)
                found[entry][:, :2] = by_row[..., i]
        return found

    def surely_sticks(self, displacement: Floats, parameters: Any, overshoot: float) -> NDArray[np.bool_]:
        """With the least friction that any speed leaves, where the inner law can tell."""
        least = parameters.mu * np.minimum(1.0, 1 - np.asarray(parameters.velocity_drop))
        return sticks_with_friction(self.inner, least, displacement, parameters, overshoot)


def friction_at(velocity: Floats, parameters: Any) -> tuple[Floats, Floats]:
    """(n, n_time) mu, and (n, 2, n_time) its derivative by the tangential velocity (n, 2, n_time) [m/s]: as
    `VelocityFriction.inner_arguments` has it."""
    mu, drop, reference = _each(parameters)
    speed, rounded = _speed(velocity, reference)
    by_speed = -mu * drop * reference / (speed + reference) ** 2
    return mu * (1 - drop * speed / (speed + reference)), (by_speed / rounded)[:, None] * velocity


def friction_by_parameters(velocity: Floats, parameters: Any) -> tuple[Floats, dict[str, Floats]]:
    """(n, n_time) mu, and its derivatives by the parameters that it depends on, each (n, n_time); velocity: as above"""
    mu, drop, reference = _each(parameters)
    speed, rounded = _speed(velocity, reference)
    factor = 1 - drop * speed / (speed + reference)
    by_reference = _ROUNDED * (_ROUNDED * reference / rounded - 1)  # of the speed
    return mu * factor, {
        "mu": factor,
        "velocity_drop": -mu * speed / (speed + reference),
        "reference_speed": -mu * drop * (by_reference * reference - speed) / (speed + reference) ** 2,
    }


def _each(parameters: Any) -> tuple[Floats, Floats, Floats]:
    """mu, drop and reference speed, each (n, 1)"""
    mu, drop, reference = (
        np.asarray(value)[:, None] for value in (parameters.mu, parameters.velocity_drop, parameters.reference_speed)
    )
    return mu, drop, reference


def _speed(velocity: Floats, reference: Floats) -> tuple[Floats, Floats]:
    """(n, n_time) size of the tangential velocity, rounded at rest; and with what rounds it."""
    corner = _ROUNDED * reference
    rounded = np.sqrt(np.sum(velocity**2, axis=1) + corner**2)
    return rounded - corner, rounded
