"""`IwanMicroslip` for numba: elements one by one, sliders one by one.

A slider stands where one sample put it, its source, so that the tangent is a sum over sources. The slip displacements
of all, and the integral, follow the largest displacement, which is a sample too: one more source.
"""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.tables import (
    GrowingTables,
    Tables,
    add_products,
    loop_area,
    sample,
    size_of_change,
)


@kept
def force_with_tangent(
    numbers: Any,
    displacement: Any,
    p: Any,
    cycles: int,
    n_sliders: int,
    reference: float,
    tables: Tables,
    force: Any,
    tangent: Any,
) -> None:
    """Writes force (n_elements, 1, n_coefficients) [N] of the elements of these numbers, and tangent (n_elements, 1,
    n_coefficients, 1, n_coefficients) [N/m] unless that has no elements.

    displacement: like force [m]; p: IwanParameters; reference: displacement [m] that they are stated for
    """
    c, n = tables.synthesis.shape
    u, position, columns = np.empty(n + 1), np.empty(n), np.empty((n + 1, c))
    for e in numbers:
        sample(displacement[e, 0], tables.synthesis, u)
        reached, at = _reached(u, p.nearness[e] / reference)
        integral = _integral(p.lost[e], p.exponent[e], reached, reference)
        columns[:] = 0.0
        _march(u, reached, p.exponent[e], at, cycles, n_sliders, tables.shares, 1.0, position, columns)
        for a in range(c):
            taken = 0.0
            for t in range(n):
                taken += tables.shares[t, a] * position[t]
            force[e, 0, a] = -integral * taken
        if len(tangent):
            tangent[e, 0, :, 0] = 0.0
            columns *= -integral
            add_products(columns, tables.values, tangent[e, 0, :, 0])


@kept
def perturbed_tangent(
    numbers: Any,
    displacement: Any,
    p: Any,
    cycles: int,
    n_sliders: int,
    reference: float,
    tables: Tables,
    growing: GrowingTables,
    tangent: Any,
) -> None:
    """As in jenkins_box.py beside this file."""
    c, n = tables.synthesis.shape
    u, position, columns = np.empty(n + 1), np.empty(n), np.empty((n + 1, c), growing.shares.dtype)
    for e in numbers:
        sample(displacement[e, 0], tables.synthesis, u)
        reached, at = _reached(u, p.nearness[e] / reference)
        columns[:] = 0.0
        _march(u, reached, p.exponent[e], at, cycles, n_sliders, growing.shares, growing.last_period, position, columns)
        columns *= -_integral(p.lost[e], p.exponent[e], reached, reference)
        tangent[e, 0, :, 0] = 0.0
        add_products(columns, growing.values, tangent[e, 0, :, 0])


@kept
def loop_areas(
    numbers: Any,
    displacement: Any,
    p: Any,
    cycles: int,
    n_sliders: int,
    reference: float,
    tables: Tables,
    areas: Any,
) -> None:
    """As in jenkins_box.py beside this file."""
    n = tables.synthesis.shape[1]
    u, position, force, nothing = np.empty(n + 1), np.empty(n), np.empty(n + 1), np.empty((0, 0))
    for i, e in enumerate(numbers):
        sample(displacement[e, 0], tables.synthesis, u)
        reached, at = _reached(u, p.nearness[e] / reference)
        _march(u, reached, p.exponent[e], at, cycles, n_sliders, tables.shares, 1.0, position, nothing)
        integral = _integral(p.lost[e], p.exponent[e], reached, reference)
        for t in range(n + 1):
            force[t] = -integral * position[t % n]
        areas[i] = loop_area(u, force)


@inner
def _reached(u: Any, nearness: float) -> Any:
    """The largest slip displacement that is reached [m], and the sample that it follows; -1 where it follows none:
    at rest, and where all sliders slip. nearness: one over the largest of all [1/m]"""
    at, largest = -1, 1e-30
    for t in range(len(u) - 1):
        if abs(u[t]) > largest:
            at, largest = t, abs(u[t])
    if nearness * largest > 1:
        return 1 / nearness, -1
    return largest, at


@inner
def _integral(lost: float, exponent: float, reached: float, reference: float) -> float:
    """Of R phi^chi up to what is reached [N/m]"""
    return lost * (2 + exponent) * (reached / reference) ** (1 + exponent)


@inner
def _march(
    u: Any,
    reached: float,
    exponent: float,
    at: int,
    cycles: int,
    n_sliders: int,
    shares: Any,
    last_period: Any,
    position: Any,
    columns: Any,
) -> None:
    """Writes the mean position of the sliders at each sample [m], and adds to columns (n_time + 1, n_coefficients),
    unless these are none, what each sample's displacement does to the coefficients of that mean; the change of the
    integral with what is reached counts as one of the positions.

    shares, last_period: of the perturbation, as in `GrowingTables`
    """
    n, by_reached = len(position), np.zeros(len(position))
    position[:] = 0.0
    for i in range(n_sliders):
        share = ((i + 0.5) / n_sliders) ** (1 / (1 + exponent))
        limit, stands, source, side = share * reached, 0.0, n, 0.0
        for cycle in range(cycles):
            for t in range(n):
                if u[t] - stands > limit:
                    stands, source, side = u[t] - limit, t, -share
                elif stands - u[t] > limit:
                    stands, source, side = u[t] + limit, t, share
                if cycle < cycles - 1:
                    continue
                position[t] += stands / n_sliders
                by_reached[t] += side / n_sliders
                if len(columns) and source < n:
                    size = size_of_change(source > t, last_period) / n_sliders
                    for a in range(columns.shape[1]):
                        columns[source, a] += size * shares[t, a]
    if at >= 0 and len(columns):
        by_reached += position * (1 + exponent) / reached
        _add_by_reached(by_reached, at, 1.0 if u[at] > 0 else -1.0, shares, last_period, columns)


@inner
def _add_by_reached(by_reached: Any, at: int, sign: float, shares: Any, last_period: Any, columns: Any) -> None:
    """What the sample at the largest displacement does to all of the period; by_reached: (n_time,) of the mean position
    and of the integral; sign: of that displacement"""
    for t in range(len(by_reached)):
        size = sign * size_of_change(at > t, last_period) * by_reached[t]
        for a in range(columns.shape[1]):
            columns[at, a] += size * shares[t, a]
