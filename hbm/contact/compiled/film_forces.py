"""A viscous film's forces and tangents, written out in NumPy.

All elements have a film, those that stick too, and JAX takes ten times as long for it as the sliders take.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import of_each
from updamp.hbm.contact.memoryless import WrittenOutForces

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ClosedShare:
    """(n, n_time) share of the time around each sample that a contact is closed, and its derivatives by the compression
    at the sample before, at the sample, and after it [1/m].
    """

    share: Floats
    by_last: Floats
    by_here: Floats
    by_next: Floats


def closed_share(compression: Floats) -> ClosedShare:
    """As `film.closed_share`. compression: (n, n_time) of the normal spring [m]"""
    before = (np.roll(compression, 1, axis=-1) + compression) / 2
    after = (np.roll(compression, -1, axis=-1) + compression) / 2
    first, by_before, by_end = _share_above_zero(before, compression)
    second, by_start, by_after = _share_above_zero(compression, after)
    here = (by_before / 2 + by_end + by_start + by_after / 2) / 2
    return ClosedShare((first + second) / 2, by_before / 4, here, by_after / 4)


def _share_above_zero(a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """Of straight lines from a to b; and its derivatives by a and by b."""
    high, low, falls = np.maximum(a, b), np.minimum(a, b), a >= b
    crosses = (high > 0) & (low < 0)
    width = np.where(crosses, high - low, 1.0)
    by_high, by_low = np.where(crosses, -low, 0.0) / width**2, np.where(crosses, high, 0.0) / width**2
    share = np.where(crosses, high / width, high > 0)
    return share, np.where(falls, by_high, by_low), np.where(falls, by_low, by_high)


@dataclass(frozen=True, eq=False)
class FilmForces(WrittenOutForces):
    """See `law.CompiledForces`. law: a `film.FilmForce`"""

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        x = displacement[numbers]
        closed = closed_share(self._compression(numbers, x, parameters)).share
        weight = _of(parameters.viscosity, numbers) * of_each(w, numbers) * closed
        force[numbers] = (weight[:, None] * (x @ self._rate.T)) @ self._analysis.T

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
        x, of = displacement[numbers], of_each(w, numbers)
        closed, viscosity = closed_share(self._compression(numbers, x, parameters)), _of(parameters.viscosity, numbers)
        speed = viscosity[:, None] * (x @ self._rate.T)
        by_frequency[numbers] = (closed.share[:, None] * speed) @ self._analysis.T
        force[numbers] = of[:, None] * by_frequency[numbers]
        same = ((viscosity * of * closed.share)[:, None] * self._analysis) @ self._rate
        found = np.zeros((len(numbers), *tangent.shape[1:]))
        for d in range(x.shape[1]):
            found[:, d, :, d] = same
        self._add_openings(closed, of[:, None] * speed, found)
        tangent[numbers] = found

    def _add_openings(self, closed: ClosedShare, speed: Floats, tangent: Floats) -> None:
        """What the normal motion changes of how long contacts are closed; speed: (n, 3, n_time), times the viscosity"""
        moving = np.flatnonzero(closed.by_here.any(axis=1))
        if not len(moving):
            return
        parts = ((closed.by_last, 1), (closed.by_here, 0), (closed.by_next, -1))
        for by, shift in parts:
            slope = (by[moving, None] * speed[moving])[:, :, None] * self._analysis
            tangent[moving, :, :, 2] += slope @ np.roll(self._synthesis, shift, axis=0)

    def _compression(self, numbers: Integers, x: Floats, parameters: Any) -> Floats:
        rest = np.asarray(self.law.rest_compression(parameters))[numbers, None]
        return np.asarray(rest + x[:, 2] @ self._synthesis.T)


def _of(values: Any, numbers: Integers) -> Floats:
    """(len(numbers), 1)"""
    return np.asarray(values, dtype=float)[numbers, None]
