"""Compiled forces of modified laws that are made of those of the law inside."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import CompiledForces, CompiledRateForces

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ShareOfMean:
    """The inner law at a motion with a share of its mean, entry `static_share` of the parameters.

    mean: places of the coefficients of the mean, none where the zero harmonic is not kept
    """

    inner: CompiledForces
    mean: slice

    def write_forces(self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats) -> None:
        self.inner.write_forces(numbers, _seen(displacement, parameters, self.mean), parameters, force)

    def write_with_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats, tangent: Floats
    ) -> None:
        seen = _seen(displacement, parameters, self.mean)
        self.inner.write_with_tangents(numbers, seen, parameters, force, tangent)
        _weigh(numbers, parameters, self.mean, tangent)

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        seen = _seen(displacement, parameters, self.mean)
        self.inner.write_perturbed_tangents(numbers, seen, parameters, growth, tangent)
        _weigh(numbers, parameters, self.mean, tangent)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        return self.inner.loop_areas(numbers, _seen(displacement, parameters, self.mean), parameters)


@dataclass(frozen=True, eq=False)
class RateShareOfMean:
    """As `ShareOfMean`, of an inner law that depends on the rate, which a mean has none of."""

    inner: CompiledRateForces
    mean: slice

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        self.inner.write_forces(numbers, _seen(displacement, parameters, self.mean), w, parameters, force)

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
        seen = _seen(displacement, parameters, self.mean)
        self.inner.write_with_tangents(numbers, seen, w, parameters, force, tangent, by_frequency)
        _weigh(numbers, parameters, self.mean, tangent)


def _seen(displacement: Floats, parameters: Any, mean: slice) -> Floats:
    seen = displacement.copy()
    seen[..., mean] *= np.asarray(parameters.static_share)[:, None, None]
    return seen


def _weigh(numbers: Integers, parameters: Any, mean: slice, tangent: NDArray[Any]) -> None:
    """What the inner law sees of the mean is a share of it."""
    share = np.asarray(parameters.static_share)[numbers]
    tangent[numbers, ..., mean] *= share[:, None, None, None, None]


@dataclass(frozen=True, eq=False)
class MeanOfSliders:
    """The mean of inner laws with other friction coefficients.

    factors: (n_sliders,) by which the spread, entry `limit_spread` of the parameters, adds to 1
    """

    inner: CompiledForces
    factors: Floats

    def write_forces(self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats) -> None:
        one, total = force.copy(), np.zeros_like(force[numbers])
        for p in _of_sliders(parameters, self.factors):
            self.inner.write_forces(numbers, displacement, p, one)
            total += one[numbers]
        force[numbers] = total / len(self.factors)

    def write_with_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, force: Floats, tangent: Floats
    ) -> None:
        one, total = (force.copy(), tangent.copy()), (np.zeros_like(force[numbers]), np.zeros_like(tangent[numbers]))
        for p in _of_sliders(parameters, self.factors):
            self.inner.write_with_tangents(numbers, displacement, p, *one)
            for sum_of, of_one in zip(total, one, strict=True):
                sum_of += of_one[numbers]
        force[numbers], tangent[numbers] = (sum_of / len(self.factors) for sum_of in total)

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        one, total = tangent.copy(), np.zeros_like(tangent[numbers])
        for p in _of_sliders(parameters, self.factors):
            self.inner.write_perturbed_tangents(numbers, displacement, p, growth, one)
            total += one[numbers]
        tangent[numbers] = total / len(self.factors)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        areas = [self.inner.loop_areas(numbers, displacement, p) for p in _of_sliders(parameters, self.factors)]
        return np.asarray(np.mean(areas, axis=0))


@dataclass(frozen=True, eq=False)
class RateMeanOfSliders:
    """As `MeanOfSliders`, of inner laws that depend on the rate."""

    inner: CompiledRateForces
    factors: Floats

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        one, total = force.copy(), np.zeros_like(force[numbers])
        for p in _of_sliders(parameters, self.factors):
            self.inner.write_forces(numbers, displacement, w, p, one)
            total += one[numbers]
        force[numbers] = total / len(self.factors)

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
        written = force, tangent, by_frequency
        one, total = [part.copy() for part in written], [np.zeros_like(part[numbers]) for part in written]
        for p in _of_sliders(parameters, self.factors):
            self.inner.write_with_tangents(numbers, displacement, w, p, *one)
            for sum_of, of_one in zip(total, one, strict=True):
                sum_of += of_one[numbers]
        for part, sum_of in zip(written, total, strict=True):
            part[numbers] = sum_of / len(self.factors)


def _of_sliders(parameters: Any, factors: Floats) -> Iterator[Any]:
    """Parameters of each slider"""
    mu, spread = np.asarray(parameters.mu, dtype=float), np.asarray(parameters.limit_spread, dtype=float)
    for factor in factors:
        yield parameters._replace(mu=(mu.T * (1 + spread * factor)).T)
