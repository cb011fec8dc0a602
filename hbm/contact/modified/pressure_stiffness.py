"""Contact stiffness that grows with the momentary pressure, as that of rough surfaces does."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import CompiledForces, compiled_forces_of, decoupled_directions_of
from updamp.hbm.contact.modified.microslip import SubPatchMicroslip
from updamp.hbm.contact.modified.modified_law import LawArguments, ModifiedLaw, rest_compression, with_entries
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction
from updamp.hbm.harmonics import Harmonics

# The share of the mean force below which the stiffness that the solver starts from falls no further; it has no
# influence on the solution.
_LEAST = 0.01


@dataclass(frozen=True)
class PressureStiffness(ModifiedLaw):
    """dN/du_n = kn (N / N_m)^m, and kt (N / N_m)^m between the surface and the slider; Hertz's contact has m = 1/3.

    Parameters pressure_exponent m [-] in [0, 1) and mean_force N_m [N], the force at which kt and kn are stated.

    Integrated, N^(1-m) is linear in the displacement, and so is the slider's reach mu N / kt(N): the slider goes where
    that of the inner law goes with kn' = (1 - m) kn and n0' = n0^(1-m) N_m^m. Its forces are then multiplied by
    (N'/N_m)^(m/(1-m)), N' with what is between the samples shared between them where the forces are: the power is steep
    where the contact opens, and a sample that opens would else meet forces that are not zero yet.
    """

    rank: ClassVar[int] = 60
    entries: ClassVar[tuple[str, ...]] = ("pressure_exponent", "mean_force")

    @property
    def decoupled_directions(self) -> tuple[int, ...]:
        return decoupled_directions_of(self.inner)

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
        from updamp.hbm.contact.compiled.box_forces import BoxForces
        from updamp.hbm.contact.compiled.pressed_forces import pressed_forces

        if isinstance(self.inner, SubPatchMicroslip):
            # all sliders have the same pressure, so that it acts on each of them as on their mean
            of_one = replace(self, inner=self.inner.inner).compiled(harmonics, n_time)
            return None if of_one is None else self.inner.mean_of(of_one)
        if isinstance(self.inner, VelocityFriction):
            # friction of the speed does not depend on how stiff the contact is
            of_any = replace(self, inner=self.inner.inner).compiled(harmonics, n_time)
            return self.inner.of_friction(of_any, harmonics, n_time)
        of_box = isinstance(compiled_forces_of(self.inner, harmonics, n_time), BoxForces)
        return pressed_forces(self.cycles, harmonics, n_time) if of_box else None

    def inner_arguments(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> LawArguments:
        p, m = parameters, parameters.pressure_exponent
        n0 = p.mean_force * power(p.n0 / p.mean_force, 1 - m)
        rest = jnp.maximum(n0 - (1 - m) * p.kn * p.gap, 0.0)
        factor = self._factor(rest, p)
        t0 = jnp.where(factor > 0, p.t0 / jnp.where(factor > 0, factor, 1.0), 0.0)
        return displacement, velocity, with_entries(p, n0=n0, kn=(1 - m) * p.kn, t0=t0)

    def outer_force(self, force: jax.Array, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        *_, p = self.inner_arguments(displacement, velocity, parameters)
        rest = jnp.maximum(p.n0 - p.kn * p.gap, 0.0)
        total = force + jnp.concatenate([p.t0, rest[None]])
        at_rest = jnp.concatenate([parameters.t0, (rest * self._factor(rest, p))[None]])
        return total * self._factor(total[:, 2], p)[:, None] - at_rest

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        share = jnp.maximum(parameters.n0 / parameters.mean_force, _LEAST)
        stiffness: jax.Array = self.inner.reference_stiffness(parameters) * share**parameters.pressure_exponent
        return stiffness

    def normal_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        normal = super().normal_force(displacement, velocity, parameters)
        return normal * self._factor(normal, parameters)

    def rest_compression(self, parameters: Any) -> NDArray[np.float64]:
        names = ("n0", "mean_force", "kn", "pressure_exponent")
        n0, mean, kn, m = (np.asarray(getattr(parameters, name), dtype=float) for name in names)
        share = np.where(n0 > 0, np.where(n0 > 0, n0, mean) / mean, 0.0) ** (1 - m)
        return rest_compression(self.inner, with_entries(parameters, n0=mean * share, kn=(1 - m) * kn))

    def _factor(self, force: jax.Array, p: Any) -> jax.Array:
        return power(force / p.mean_force, p.pressure_exponent / (1 - p.pressure_exponent))


def power(base: jax.Array, exponent: jax.Array) -> jax.Array:
    """base^exponent, 0 where the base is: with derivatives that stay finite there."""
    positive = base > 0
    return jnp.where(positive, jnp.where(positive, base, 1.0) ** exponent, 0.0)
