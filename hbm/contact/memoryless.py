"""Forces that follow from the motion at the same instant: coefficients and tangents from slopes that are written out.

Springs and dampers come in ones and twos, and are evaluated some hundred thousand times in a fit. A call of JAX takes
0.3 ms whatever is in it, and a law is compiled for every set of harmonics; NumPy takes a fifth of that, and nothing to
compile.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw, of_each
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Sampled(NamedTuple):
    """Forces at the time samples [N] and what changes them, each (n_elements, n_time), None where nothing does.

    by_displacement [N/m], by_velocity [N s/m]: at the same sample; by_last, by_next [N/m]: by the displacement at the
        sample before and after, of a law that follows what happens between samples
    """

    force: Floats
    by_displacement: Floats | None = None
    by_velocity: Floats | None = None
    by_last: Floats | None = None
    by_next: Floats | None = None

    def of(self, elements: slice) -> "Sampled":
        return Sampled(self.force[elements], *(None if slope is None else slope[elements] for slope in self[1:]))

    def times(self, factor: Floats) -> "Sampled":
        return Sampled(factor * self.force, *(None if slope is None else factor * slope for slope in self[1:]))

    def opposite_way(self) -> "Sampled":
        """Of the opposite displacement, in the opposite direction."""
        return self._replace(force=-self.force)

    def plus(self, other: "Sampled") -> "Sampled":
        """Of a law with the same slopes."""
        slopes = zip(self[1:], other[1:], strict=True)
        return Sampled(self.force + other.force, *(None if a is None or b is None else a + b for a, b in slopes))


@runtime_checkable
class MemorylessLaw(ContactLaw, Protocol):
    """A law of one direction that is written out a second time, in NumPy. `force` remains its definition, for whatever
    needs more than coefficients and their derivatives by the motion."""

    def sampled(self, displacement: Floats, velocity: Floats, parameters: Any) -> Sampled:
        """The samples that Fourier coefficients are taken from (`law.force_for_analysis`).

        displacement [m], velocity [m/s]: (n_elements, n_time); parameters: entries (n_elements, 1)
        """
        ...


@dataclass(frozen=True, eq=False)
class WrittenOutForces:
    """A law that is written out in NumPy, and what its samples are made of and go into."""

    law: Any
    harmonics: Harmonics
    n_time: int

    @cached_property
    def _synthesis(self) -> Floats:
        """(n_time, n_coefficients)"""
        return np.asarray(self.harmonics.synthesis(self.n_time))

    @cached_property
    def _rate(self) -> Floats:
        """Likewise, of the velocity over the angular frequency."""
        return np.asarray(self.harmonics.synthesis_rate(self.n_time))

    @cached_property
    def _analysis(self) -> Floats:
        """(n_coefficients, n_time)"""
        return np.asarray(self.harmonics.analysis(self.n_time))


@dataclass(frozen=True, eq=False)
class MemorylessForces(WrittenOutForces):
    """See `law.CompiledForces`."""

    law: MemorylessLaw

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        """w: one for all elements, or (n_elements,)"""
        x, of = displacement[numbers, 0], of_each(w, numbers)
        force[numbers, 0] = self._sampled(numbers, x, of * (x @ self._rate.T), parameters).force @ self._analysis.T

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
        """w: one for all elements, or (n_elements,)"""
        x, analysis, motion = displacement[numbers, 0], self._analysis, self._synthesis
        speed, of = x @ self._rate.T, of_each(w, numbers)
        found = self._sampled(numbers, x, of * speed, parameters)
        force[numbers, 0] = found.force @ analysis.T
        total = np.zeros((len(numbers), len(analysis), len(analysis)))
        parts = [(found.by_displacement, motion), (found.by_last, self._last), (found.by_next, self._next)]
        by_velocity = None if found.by_velocity is None else of * found.by_velocity
        for slope, samples in (*parts, (by_velocity, self._rate)):
            if slope is not None:
                total += (slope[:, None] * analysis) @ samples
        tangent[numbers, 0, :, 0] = total
        if found.by_velocity is not None:
            by_frequency[numbers, 0] = (found.by_velocity * speed) @ analysis.T

    def _sampled(self, numbers: Integers, x: Floats, velocity: Floats, parameters: Any) -> Sampled:
        """x: (n, n_coefficients), velocity: (n, n_time), of the elements of these numbers"""
        each = type(parameters)(*(np.asarray(value)[numbers, None] for value in parameters))
        return self.law.sampled(x @ self._synthesis.T, velocity, each)

    @cached_property
    def _last(self) -> Floats:
        """Of the displacement at the sample before."""
        return np.roll(self._synthesis, 1, axis=0)

    @cached_property
    def _next(self) -> Floats:
        return np.roll(self._synthesis, -1, axis=0)
