"""Groups of contact elements that obey one law, and their forces in the frequency domain (AFT) with exact tangents."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import (
    CompiledForces,
    CompiledHysteresis,
    ContactLaw,
    as_sticking_law,
    compiled_forces_of,
    is_of_its_force,
    parts_of,
)
from updamp.hbm.contact.memoryless import MemorylessForces, MemorylessLaw
from updamp.hbm.contact.sticking import overshoot_between_samples
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.element_checks import as_arrays, refuse_impossible, whole_rows
from updamp.hbm.problem.laws_in_jax import (
    compiled_force,
    compiled_loop_areas,
    compiled_quantity,
    compiled_reference_stiffness,
    compiled_with_tangents,
    elements_a_batch,
    n_seeds,
)
from updamp.hbm.problem.own_law_checks import refuse_contradictions

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Elements in one batch of forces alone, small enough for the processor's cache.
FORCES_A_BATCH = 12
# Samples that tell which elements stick where the law itself is evaluated at more.
STICKING_SAMPLES = 128


@dataclass(frozen=True, eq=False)
class ElementGroup:
    """Elements of one law.

    parameters: the law's NamedTuple, each entry (n_elements, ...); lists become arrays
    rows: (n_elements, law.directions) rows of the linear model that the elements act on
    copies: (n_elements,) how many that move alike each stands for (hbm/problem/mirror.py); None: one

    raises: ValueError naming an entry or a shape that cannot be; TypeError naming what is no law, or no number
    """

    law: ContactLaw
    parameters: Any
    rows: Integers
    copies: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", whole_rows(self.rows))
        object.__setattr__(self, "parameters", as_arrays(self.parameters))
        refuse_impossible(self.law, self.parameters, self.rows)
        refuse_contradictions(self.law, self.parameters)

    def reference_stiffness(self) -> Floats:
        """(n_elements, directions) of all copies together [N/m]"""
        return self.of_all_copies(self.stiffness_of_one)

    @cached_property
    def stiffness_of_one(self) -> Floats:
        """(n_elements, directions) [N/m]"""
        return np.asarray(compiled_reference_stiffness(self.law)(self.parameters))

    def of_all_copies(self, value: NDArray[Any], numbers: Integers | None = None) -> NDArray[Any]:
        """(n_elements, ...) of one element each -> of all of its copies together; numbers: which elements, None: all"""
        if self.copies is None:
            return value
        copies = self.copies if numbers is None else self.copies[numbers]
        return value * copies.reshape(-1, *[1] * (value.ndim - 1))

    @cached_property
    def parts(self) -> "tuple[ElementGroup, ...]":
        """The same elements with each of the laws that theirs is the sum of; none where it is no sum."""
        return tuple(replace(self, law=law) for law in parts_of(self.law))

    @cached_property
    def values(self) -> Any:
        """The parameters as NumPy arrays: some of the elements are picked out of them at every evaluation."""
        return type(self.parameters)(*(np.asarray(value) for value in self.parameters))

    def may_slip_or_separate(self, displacement: Floats, harmonics: Harmonics, n_time: int) -> Integers:
        """Numbers of the elements that do not surely stick; displacement: (n_elements, directions, n_coefficients)"""
        law = as_sticking_law(self.law)
        if law is None:
            return np.arange(len(displacement))
        overshoot = overshoot_between_samples(harmonics.orders[-1], n_time)
        motion = (displacement.reshape(-1, displacement.shape[2]) @ _synthesis(harmonics, n_time)).reshape(
            *displacement.shape[:2], n_time
        )
        return np.flatnonzero(~law.surely_sticks(motion, self.values, overshoot))

    def repeated(self, n: int) -> "ElementGroup":
        """The same elements n times over, as in n motions of theirs. For forces alone: no rows are theirs twice."""
        parameters = type(self.values)(*(np.concatenate([value] * n) for value in self.values))
        copies = None if self.copies is None else np.concatenate([self.copies] * n)
        again = replace(self, parameters=parameters, rows=np.concatenate([self.rows] * n), copies=copies)
        # what is known of one element is known of all that are the same
        again.__dict__["stiffness_of_one"] = np.concatenate([self.stiffness_of_one] * n)
        again.__dict__["parts"] = tuple(part.repeated(n) for part in self.parts)
        return again


@lru_cache(maxsize=64)
def compiled_forces(law: ContactLaw, harmonics: Harmonics, n_time: int) -> CompiledForces | None:
    """By numba or NumPy; None where the law is in JAX alone."""
    if isinstance(law, MemorylessLaw) and is_of_its_force(law, "sampled"):
        return MemorylessForces(law, harmonics, n_time)
    return compiled_forces_of(law, harmonics, n_time)


@lru_cache(maxsize=64)
def compiled_hysteresis(law: ContactLaw, harmonics: Harmonics, n_time: int) -> CompiledHysteresis | None:
    """None where JAX alone tells loops, and the answer to what grows. Kept: to look at a protocol takes 40 us."""
    forces = None if law.rate_dependent else compiled_forces(law, harmonics, n_time)
    return forces if isinstance(forces, CompiledHysteresis) else None


@lru_cache(maxsize=32)
def _synthesis(harmonics: Harmonics, n_time: int) -> Floats:
    """(n_coefficients, n_time)"""
    return np.ascontiguousarray(harmonics.synthesis(n_time).T)


@dataclass(frozen=True, eq=False)
class ElementForces:
    """Fourier coefficients of the forces, or of what departs from the reference springs, and their derivatives.

    force: (n_elements, directions, n_coefficients) [N]
    tangent: (n_elements, directions, n_coefficients, directions, n_coefficients) [N/m]
    frequency_derivative: like force, with respect to the angular frequency [N s]; None for rate-independent laws
    """

    force: Floats
    tangent: Floats
    frequency_derivative: Floats | None


def element_forces(
    group: ElementGroup, displacement: Floats, w: float, harmonics: Harmonics, n_time: int
) -> ElementForces:
    """Alternating frequency-time: coefficients -> samples -> law -> coefficients (Cameron and Griffin 1989).

    displacement: (n_elements, directions, n_coefficients) [m]
    """
    found, stiffness = departures(group, displacement, w, harmonics, n_time), group.reference_stiffness()
    _diagonal(found.tangent)[:] += stiffness[..., None]
    return ElementForces(found.force + stiffness[..., None] * displacement, found.tangent, found.frequency_derivative)


def departures(
    group: ElementGroup, displacement: Floats, w: float | Floats, harmonics: Harmonics, n_time: int
) -> ElementForces:
    """As `element_forces`, less the forces of the reference springs: elements that surely stick are not evaluated, and
    have none.

    w: one, or (n_elements,) of laws that take several (`elements_together.py`)
    """
    if group.parts:
        return _sum_of([departures(part, displacement, w, harmonics, n_time) for part in group.parts])
    active, stiffness = group.may_slip_or_separate(displacement, harmonics, n_time), group.stiffness_of_one
    force = np.zeros_like(displacement)
    tangent = np.zeros((*displacement.shape, *displacement.shape[1:]))
    rate = np.zeros_like(force)
    compiled = compiled_forces(group.law, harmonics, n_time)
    if compiled is not None:
        compiled.write_with_tangents(active, displacement, w, group.values, force, tangent, rate)
    else:
        evaluate = compiled_with_tangents(group.law, harmonics, n_time)
        for some in _batches(active, elements_a_batch(n_seeds(group.law, harmonics)), len(displacement)):
            found = evaluate(displacement[some], w, _parameters_of(group, some))
            force[some], tangent[some] = found[:2]
            if group.law.rate_dependent:
                rate[some] = found[2]
    force[active] -= stiffness[active][..., None] * displacement[active]
    _diagonal(tangent)[active] -= stiffness[active][..., None]
    by_frequency = group.of_all_copies(rate) if group.law.rate_dependent else None
    return ElementForces(group.of_all_copies(force), group.of_all_copies(tangent), by_frequency)


def _sum_of(parts: Sequence[ElementForces]) -> ElementForces:
    rates = [part.frequency_derivative for part in parts if part.frequency_derivative is not None]
    return ElementForces(
        np.sum([part.force for part in parts], axis=0),
        np.sum([part.tangent for part in parts], axis=0),
        np.sum(rates, axis=0) if rates else None,
    )


def _diagonal(tangent: Floats) -> Floats:
    """(n_elements, directions, n_coefficients), to be written to"""
    n, d, c = tangent.shape[:3]
    return np.einsum("eii->ei", tangent.reshape(n, d * c, d * c)).reshape(n, d, c)


def force_only(group: ElementGroup, displacement: Floats, w: float, harmonics: Harmonics, n_time: int) -> Floats:
    """The forces alone, several times cheaper than with their tangent."""
    stiffness = group.reference_stiffness()[..., None]
    return departure_only(group, displacement, w, harmonics, n_time) + stiffness * displacement


def departure_only(
    group: ElementGroup, displacement: Floats, w: float | Floats, harmonics: Harmonics, n_time: int
) -> Floats:
    """As `departures`, without the tangent"""
    if group.parts:
        each = [departure_only(part, displacement, w, harmonics, n_time) for part in group.parts]
        return np.asarray(np.sum(each, axis=0))
    force = np.zeros_like(displacement)
    active, stiffness = group.may_slip_or_separate(displacement, harmonics, n_time), group.stiffness_of_one
    compiled = compiled_forces(group.law, harmonics, n_time)
    if compiled is not None:
        compiled.write_forces(active, displacement, w, group.values, force)
    else:
        evaluate = compiled_force(group.law, harmonics, n_time)
        for some in _batches(active, FORCES_A_BATCH, len(displacement)):
            force[some] = evaluate(displacement[some], w, _parameters_of(group, some))
    force[active] -= stiffness[active][..., None] * displacement[active]
    return group.of_all_copies(force)


def _batches(numbers: Integers, size: int, n_elements: int) -> Iterator[Integers]:
    """All of the same size, so that a law is compiled once: the last one is filled up with elements of its own."""
    for start in range(0, len(numbers), size):
        yield np.resize(numbers[start : start + size], min(size, n_elements))


def _parameters_of(group: ElementGroup, numbers: Integers) -> Any:
    """Parameters of some of the elements."""
    return type(group.values)(*(value[numbers] for value in group.values))


def over_period(
    group: ElementGroup,
    quantity: Callable[[jax.Array, jax.Array, Any], jax.Array],
    displacement: Floats,
    w: float,
    harmonics: Harmonics,
    n_time: int,
) -> tuple[Floats, Floats]:
    """Samples of the motion (n_elements, n_time, directions) [m] and of a quantity of the law, such as `law.force`."""
    motion, value = compiled_quantity(quantity, harmonics, n_time)(displacement, w, group.parameters)
    return np.asarray(motion), np.asarray(value)


def loop_areas(group: ElementGroup, displacement: Floats, w: float, harmonics: Harmonics, n_time: int) -> Floats:
    """(n_elements,) integral of f dx over a period by the trapezoidal rule [J]."""
    compiled = compiled_hysteresis(group.law, harmonics, n_time)
    if compiled is not None:
        areas = np.zeros(len(displacement))  # of elements that stick
        active = group.may_slip_or_separate(displacement, harmonics, min(n_time, STICKING_SAMPLES))
        areas[active] = compiled.loop_areas(active, displacement, group.values)
        return group.of_all_copies(areas)
    found = compiled_loop_areas(group.law, harmonics, n_time)(displacement, w, group.parameters)
    return group.of_all_copies(np.asarray(found))
