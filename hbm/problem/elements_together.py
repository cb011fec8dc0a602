"""Forces of the same elements in many motions: a law that is compiled, or written out, is called once for all."""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import (
    ElementForces,
    ElementGroup,
    compiled_forces,
    departure_only,
    departures,
)

Floats = NDArray[np.float64]


def departures_only_together(
    group: ElementGroup, displacement: Floats, w: Floats, harmonics: Harmonics, n_time: int
) -> Floats:
    """As `departure_only`, of n motions: (n, n_elements, directions, n_coefficients), w: (n,)"""
    if not _takes_many(group, harmonics, n_time):
        each = zip(displacement, w.tolist(), strict=True)
        return np.array([departure_only(group, x, of, harmonics, n_time) for x, of in each])
    force = departure_only(group.repeated(len(w)), *_flat(displacement, w), harmonics, n_time)
    return force.reshape(displacement.shape)


def departures_together(
    group: ElementGroup, displacement: Floats, w: Floats, harmonics: Harmonics, n_time: int
) -> list[ElementForces]:
    """As `departures`, of each of n motions: (n, n_elements, directions, n_coefficients), w: (n,)"""
    n = len(w)
    if not _takes_many(group, harmonics, n_time):
        each = zip(displacement, w.tolist(), strict=True)
        return [departures(group, x, of, harmonics, n_time) for x, of in each]
    found = departures(group.repeated(n), *_flat(displacement, w), harmonics, n_time)
    force = found.force.reshape(displacement.shape)
    tangent = found.tangent.reshape(*displacement.shape, *displacement.shape[2:])
    if found.frequency_derivative is None:
        return [ElementForces(force[i], tangent[i], None) for i in range(n)]
    rate = found.frequency_derivative.reshape(displacement.shape)
    return [ElementForces(force[i], tangent[i], rate[i]) for i in range(n)]


def _takes_many(group: ElementGroup, harmonics: Harmonics, n_time: int) -> bool:
    """Whether a call of its law may hold motions of several frequencies, and is worth it: one of JAX is compiled for
    every number of elements."""
    if group.parts:
        return all(_takes_many(part, harmonics, n_time) for part in group.parts)
    return compiled_forces(group.law, harmonics, n_time) is not None


def _flat(displacement: Floats, w: Floats) -> tuple[Floats, Floats]:
    n, n_elements = displacement.shape[:2]
    return displacement.reshape(n * n_elements, *displacement.shape[2:]), np.repeat(w, n_elements)
