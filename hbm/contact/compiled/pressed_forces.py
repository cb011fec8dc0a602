"""The box law with stiffness that depends on the pressure, compiled."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from updamp.hbm.contact.compiled import pressed_box
from updamp.hbm.contact.compiled.kernel_forces import Complex, Floats, FrictionKernelForces, Integers, own
from updamp.hbm.contact.compiled.pressed_box import PressedBox
from updamp.hbm.contact.compiled.tables import growing, growing_sampled, sampled, tables
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.harmonics import Harmonics


@dataclass(frozen=True, eq=False)
class PressedForces(FrictionKernelForces):
    """The arguments are the cycles, `tables.sampled` and the tables."""

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        _, at_samples, of_motion = self.arguments
        grown = growing_sampled(at_samples.shape[1], growth), growing(of_motion, growth)
        self.perturbed(numbers, own(displacement), self.own(parameters), *self.arguments, *grown, tangent)


def pressed_forces(cycles: int, harmonics: Harmonics, n_time: int) -> PressedForces:
    """Of `PressureStiffness` with `JenkinsBox` inside."""
    law, arguments = pressed_box, (cycles, sampled(n_time), tables(harmonics, n_time))
    forces = law.force_with_tangent, law.perturbed_tangent, law.loop_areas
    return PressedForces(*forces, _own, arguments, law.by_friction)


def _own(p: Any) -> PressedBox:
    """As `PressureStiffness.inner_arguments` and `outer_force` have them."""
    names = ("mu", "kt", "kn", "n0", "t0", "gap", "pressure_exponent", "mean_force")
    mu, kt, kn, n0, t0, gap, m, mean = (np.array(getattr(p, name), dtype=np.float64) for name in names)
    exponent, stiffness = m / (1 - m), (1 - m) * kn
    pressing = mean * _power(n0 / mean, 1 - m)
    rest = np.maximum(pressing - stiffness * gap, 0.0)
    factor = _power(rest / mean, exponent)
    first = np.where(factor > 0, 1 / np.where(factor > 0, factor, 1.0), 0.0)[:, None] * t0
    box: Any = FrictionParameters
    inside = box(mu.reshape(len(mu), -1), kt, stiffness, pressing, first, gap)
    return PressedBox(inside, exponent, mean, np.column_stack([t0, rest * factor]))


def _power(base: Floats, exponent: Floats) -> Floats:
    """As `pressure_stiffness.power`"""
    positive = base > 0
    return np.asarray(np.where(positive, np.where(positive, base, 1.0) ** exponent, 0.0))
