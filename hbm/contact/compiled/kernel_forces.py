"""A law's compiled functions as `law.CompiledHysteresis`: what Python hands to them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.tables import growing

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class KernelForces:
    """evaluate, perturbed, areas: compiled functions (numbers, displacement, parameters, *arguments, ...); what they
    write comes last, and the last of the arguments are the tables

    own: gives parameters in arrays of one kind, whatever they were: numba compiles once for each kind, and read-only
        ones are another
    """

    evaluate: Callable[..., None]
    perturbed: Callable[..., None]
    areas: Callable[..., None]
    own: Callable[[Any], Any]
    arguments: tuple[Any, ...]

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        of_one = displacement.shape[1:]
        self._evaluate(numbers, displacement, parameters, force, np.empty((0, *of_one, *of_one)))

    def write_with_tangents(
        self,
        numbers: Integers,
        displacement: Floats,
        w: float | Floats,
        parameters: Any,
        force: Floats,
        tangent: Floats,
        by_frequency: Floats,
    ) -> None:
        self._evaluate(numbers, displacement, parameters, force, tangent)

    def _evaluate(
        self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats, tangent: Floats
    ) -> None:
        self.evaluate(numbers, own(displacement), self.own(parameters), *self.arguments, force, tangent)

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        grown = growing(self.arguments[-1], growth)
        self.perturbed(numbers, own(displacement), self.own(parameters), *self.arguments, grown, tangent)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        areas = np.empty(len(numbers))
        self.areas(numbers, own(displacement), self.own(parameters), *self.arguments, areas)
        return areas


@dataclass(frozen=True, eq=False)
class FrictionKernelForces(KernelForces):
    """As `law.CompiledFriction`. of_friction: as `evaluate`, with the friction coefficient's derivatives before what it
    writes"""

    of_friction: Callable[..., None]

    def by_friction(self, numbers: Integers, displacement: Floats, parameters: Any, mu_rows: Floats) -> Floats:
        found = np.empty((len(numbers), 2, displacement.shape[2], mu_rows.shape[2]))
        arguments = self.own(parameters), *self.arguments, own(mu_rows), found
        self.of_friction(numbers, own(displacement), *arguments)
        return found


def own(displacement: Floats) -> Floats:
    return np.require(displacement, np.float64, ["C", "W"])
