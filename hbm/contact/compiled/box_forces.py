"""The box laws as `law.CompiledForces`: what Python hands to the compiled functions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled import jenkins_box, jenkins_box_sampled
from updamp.hbm.contact.compiled.tables import growing, tables
from updamp.hbm.contact.event_march import most_corners
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class BoxForces:
    """evaluate, perturbed, areas: compiled functions (numbers, displacement, parameters, *arguments, ...); what they
    write comes last
    """

    evaluate: Callable[..., None]
    perturbed: Callable[..., None]
    areas: Callable[..., None]
    arguments: tuple[Any, ...]

    def write_forces(self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats) -> None:
        c = displacement.shape[2]
        self.write_with_tangents(numbers, displacement, parameters, force, np.empty((0, 3, c, 3, c)))

    def write_with_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats, tangent: Floats
    ) -> None:
        motion = np.require(displacement, np.float64, ["C", "W"])
        self.evaluate(numbers, motion, _own(parameters), *self.arguments, force, tangent)

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        motion = np.require(displacement, np.float64, ["C", "W"])
        grown = growing(self.arguments[-1], growth)
        self.perturbed(numbers, motion, _own(parameters), *self.arguments, grown, tangent)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        areas = np.empty(len(numbers))
        motion = np.require(displacement, np.float64, ["C", "W"])
        self.areas(numbers, motion, _own(parameters), *self.arguments, areas)
        return areas


def between_samples(cycles: int, harmonics: Harmonics, n_time: int) -> BoxForces:
    """Of `JenkinsBox`."""
    most = most_corners(n_time), most_corners(2 * n_time)
    law, arguments = jenkins_box, (cycles, most, tables(harmonics, n_time))
    return BoxForces(law.force_with_tangent, law.perturbed_tangent, law.loop_areas, arguments)


def at_samples(cycles: int, harmonics: Harmonics, n_time: int) -> BoxForces:
    """Of `SampledJenkinsBox`."""
    law, arguments = jenkins_box_sampled, (cycles, tables(harmonics, n_time))
    return BoxForces(law.force_with_tangent, law.perturbed_tangent, law.loop_areas, arguments)


def _own(p: Any) -> FrictionParameters:
    """Arrays of one kind, whatever they were: numba compiles once for each kind, and read-only ones are another."""
    mu, *others = (np.array(value, dtype=np.float64) for value in (p.mu, p.kt, p.kn, p.n0, p.t0, p.gap))
    return FrictionParameters(mu.reshape(len(mu), -1), *others)  # type: ignore[arg-type]
