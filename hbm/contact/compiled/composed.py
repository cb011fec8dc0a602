"""Compiled forces of modified laws that are made of those of the law inside."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ShareOfMean:
    """The inner law at a motion with a share of its mean, entry `static_share` of the parameters.

    inner: `law.CompiledHysteresis`; `CompiledForces` of a law that depends on the rate, of which no loops are asked
    mean: places of the coefficients of the mean, none where the zero harmonic is not kept
    """

    inner: Any
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

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        seen = _seen(displacement, parameters, self.mean)
        self.inner.write_perturbed_tangents(numbers, seen, parameters, growth, tangent)
        _weigh(numbers, parameters, self.mean, tangent)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        return self.inner.loop_areas(numbers, _seen(displacement, parameters, self.mean), parameters)


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

    inner: as of `ShareOfMean`
    factors: (n_sliders,) by which the spread, entry `limit_spread` of the parameters, adds to 1
    """

    inner: Any
    factors: Floats

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        for one in _write_mean(numbers, self._each(parameters), force):
            self.inner.write_forces(numbers, displacement, w, *one)

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
        for one in _write_mean(numbers, self._each(parameters), force, tangent, by_frequency):
            self.inner.write_with_tangents(numbers, displacement, w, *one)

    def write_perturbed_tangents(
        self, numbers: Integers, displacement: Floats, parameters: Any, growth: complex, tangent: Complex
    ) -> None:
        for of_slider, one in _write_mean(numbers, self._each(parameters), tangent):
            self.inner.write_perturbed_tangents(numbers, displacement, of_slider, growth, one)

    def loop_areas(self, numbers: Integers, displacement: Floats, parameters: Any) -> Floats:
        areas = [self.inner.loop_areas(numbers, displacement, p) for p in self._each(parameters)]
        return np.asarray(np.mean(areas, axis=0))

    def _each(self, parameters: Any) -> list[Any]:
        return _of_sliders(parameters, self.factors)


def _of_sliders(parameters: Any, factors: Floats) -> list[Any]:
    """Parameters of each slider"""
    mu, spread = np.asarray(parameters.mu, dtype=float), np.asarray(parameters.limit_spread, dtype=float)
    return [parameters._replace(mu=(mu.T * (1 + spread * factor)).T) for factor in factors]


def _write_mean(numbers: Integers, sliders: Sequence[Any], *written: NDArray[Any]) -> Iterator[tuple[Any, ...]]:
    """Parameters of each slider with arrays, which are to be filled with what it does before the next is asked for;
    then the mean of them is written to the rows `numbers`."""
    one, total = [part.copy() for part in written], [np.zeros_like(part[numbers]) for part in written]
    for of_slider in sliders:
        yield of_slider, *one
        for sum_of, of_one in zip(total, one, strict=True):
            sum_of += of_one[numbers]
    for part, sum_of in zip(written, total, strict=True):
        part[numbers] = sum_of / len(sliders)
