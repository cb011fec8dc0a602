"""Micro-slip in a joint: Iwan's parallel sliders, with a power law for the displacement at which they slip.

A slider i behind a spring is a play operator: it moves where the spring has been stretched by its slip displacement
phi. With density rho(phi) = R phi^chi up to phi_max (D. J. Segalman, J. Appl. Mech. 72 (2005) 752, without the jump of
stiffness at phi_max) the joint's force is K u - int rho(phi) w(t, phi) dphi, w the sliders' positions. The first term,
K = R phi_max^(1+chi) / (1+chi), is the stiffness while all stick: it belongs to the structure whose modes were
identified at small amplitude. The law is what is left:

    f = - int_0^min(A, phi_max) R phi^chi w(t, phi) dphi,   A the largest displacement,

which is finite where phi_max is far beyond what was measured, and K cannot be known. Below phi_max, at amplitude A:

    loop area D = 4 R A^(3+chi) / ((2+chi) (3+chi)),
    stiffness lost on first loading R A^(1+chi) / ((1+chi) (2+chi)).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.friction import last_cycle
from updamp.hbm.contact.law import CompiledForces
from updamp.hbm.harmonics import Harmonics

# At which the stiffness lost is stated [m].
REFERENCE_DISPLACEMENT = 1e-4
_SLIDERS = 32


class IwanParameters(NamedTuple):
    """lost: stiffness [N/m] lost on first loading to `REFERENCE_DISPLACEMENT`; exponent: chi, above -1; nearness: that
    displacement over phi_max, 0 where gross slip is out of reach"""

    lost: jax.Array
    exponent: jax.Array
    nearness: jax.Array


@dataclass(frozen=True)
class IwanMicroslip:
    """Sliders are placed within the present amplitude, so that loop and stiffness follow the power exactly, whatever
    their number. Loops have 0.05 to 0.2 % more area than those of infinitely many (exponents of -0.5 to 1).

    cycles: marched until the history has settled
    """

    cycles: int = 2
    settles_in: ClassVar[int] = 2
    parameters: ClassVar[type] = IwanParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False
    at_least: ClassVar[Mapping[str, float]] = {"lost": 0.0, "nearness": 0.0}
    above: ClassVar[Mapping[str, float]] = {"exponent": -1.0}

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: IwanParameters) -> jax.Array:
        chi = parameters.exponent
        # a motion of nothing has no sliders that move, but still a derivative
        largest = jnp.maximum(jnp.max(jnp.abs(displacement)), 1e-30)
        reached = 1 / jnp.maximum(1 / largest, parameters.nearness / REFERENCE_DISPLACEMENT)
        # int_0^reached R phi^chi g dphi with phi = reached t^(1/(1+chi)): the mean of g over t, times R's integral
        phi = reached * ((jnp.arange(_SLIDERS) + 0.5) / _SLIDERS) ** (1 / (1 + chi))
        integral = parameters.lost * (2 + chi) * (reached / REFERENCE_DISPLACEMENT) ** (1 + chi)

        def step(slider: jax.Array, u: jax.Array) -> tuple[jax.Array, jax.Array]:
            moved = jnp.clip(slider, u - phi, u + phi)
            return moved, jnp.mean(moved)

        position = last_cycle(step, jnp.zeros(_SLIDERS), displacement[:, 0], self.cycles)
        return -integral * position[:, None]

    def compiled(self, harmonics: Harmonics, n_time: int) -> CompiledForces:
        from updamp.hbm.contact.compiled.iwan_forces import iwan_forces

        return iwan_forces(self.cycles, _SLIDERS, REFERENCE_DISPLACEMENT, harmonics, n_time)

    def reference_stiffness(self, parameters: IwanParameters) -> jax.Array:
        return jnp.zeros(1)
