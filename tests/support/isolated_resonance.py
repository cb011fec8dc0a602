"""An oscillator with an isolated resonance, known in closed form for one harmonic."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import numpy as np
from support.peers import one_degree_of_freedom

from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation, NonlinearSystem

DAMPING, SECOND, FOURTH = 0.1, -0.24, 0.08
FORCE, WINDOW = 0.03, (0.8 / 2 / np.pi, 1.2 / 2 / np.pi)


class DipParameters(NamedTuple):
    """second, fourth: damping by u^2 [N s/m^3] and by u^4 [N s/m^5]"""

    second: jax.Array
    fourth: jax.Array


@dataclass(frozen=True)
class DipInDamping:
    """f = (second u^2 + fourth u^4) v. Of u = a cos(w t) the first harmonic is that of a damper second a^2 / 4 +
    fourth a^4 / 8."""

    parameters: ClassVar[type] = DipParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = True

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: DipParameters) -> jax.Array:
        return (parameters.second * displacement**2 + parameters.fourth * displacement**4) * velocity

    def reference_stiffness(self, parameters: DipParameters) -> jax.Array:  # noqa: ARG002
        return np.zeros(1)


def isolated_resonance() -> tuple[NonlinearSystem, CurveRequest]:
    """Mass 1 kg on 1 N/m. At its resonance, w = 1, a (c + c2 a^2 / 4 + c4 a^4 / 8) = F has three solutions at this
    force (`resonances`): the lowest is the peak of the curve, the others are top and bottom of a closed loop. Steps are
    so short that points lie near these."""
    group = ElementGroup(DipInDamping(), DipParameters(np.array([SECOND]), np.array([FOURTH])), np.array([[0]]))
    system = one_degree_of_freedom(DAMPING, group, (0, 1), 128)
    options = ContinuationOptions(largest_step=0.1)
    return system, CurveRequest("1", Excitation(system.free.row("mass"), FORCE), WINDOW, ("mass",), options=options)


def resonances() -> np.ndarray:
    """(3,) amplitudes [m], rising"""
    roots = np.roots([FOURTH / 8, 0, SECOND / 4, 0, DAMPING, -FORCE])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return np.sort(real[real > 0])
