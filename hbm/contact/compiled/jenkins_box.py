"""`JenkinsBox` for numba: elements one by one, events between the samples (`event_march.py`, which defines it)."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.at_rest import rests, stays_closed
from updamp.hbm.contact.compiled.columns import Rows
from updamp.hbm.contact.compiled.cubic import positive
from updamp.hbm.contact.compiled.event_grid import build_grid, find_openings, new_grid, new_openings, new_path
from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.normal import (
    add_missing,
    add_missing_tangent,
    ever_closes,
    identity,
    limit_rows,
    set_limits,
    write_block,
    write_normal,
    write_tangential,
)
from updamp.hbm.contact.compiled.shared import SLIDER_STANDS
from updamp.hbm.contact.compiled.slider import add_force, add_tangent, march, new_scratch, new_slider, tell_apart
from updamp.hbm.contact.compiled.tables import GrowingTables, Tables, loop_area, sample, slope


@kept
def force_with_tangent(
    numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, force: Any, tangent: Any
) -> None:
    """Writes force (n_elements, 3, n_coefficients) [N] of the elements of these numbers, and tangent (n_elements, 3,
    n_coefficients, 3, n_coefficients) [N/m] unless that has no elements.

    displacement: like force [m]; p: FrictionParameters, mu of shape (n_elements, 1), or (n_elements, n_time) where it
        varies over the period
    """
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, missing = room(n, c)
    slider, out = new_slider(len(grid.share), n), new_scratch(len(grid.share), tables.weights)
    rows, own = rows_of(tables)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        press(coefficients[2], p, e, tables, pressing, rate, openings)
        missing[:] = 0.0
        add_missing(pressing, rate, openings, tables.weights, missing)
        presses, rest = ever_closes(pressing, openings), p.n0[e] - kn * p.gap[e]
        write_normal(presses, missing, coefficients[2], rest, kn, tables.constant, force[e, 2])
        if len(tangent):
            _write_normal_tangent(pressing, openings, kn, rows, tables.weights, out, tangent[e, 2], False)
        ratio, p_rows = hold(p, e, pressing, rate, path, openings), limit_rows(p.mu[e], rows, 1.0, own)
        for d in range(2):
            slide(coefficients[d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            tell_apart(grid, path, ratio, slider)
            out.force[:] = coefficients[d]
            add_force(grid, path, ratio, slider, tables.weights, out)
            for a in range(c):
                force[e, d, a] = kt * out.force[a] - p.t0[e, d] * tables.constant[a]
            if len(tangent):
                identity(out.by_u)
                out.by_p[:] = 0.0
                add_tangent(grid, path, rows, p_rows, ratio, slider, tables.weights, 1.0, out)
                write_tangential(kt, out.by_u, out.by_p, d, tangent[e, d])


@kept
def perturbed_tangent(
    numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, growing: GrowingTables, tangent: Any
) -> None:
    """Writes the tangent of `force_with_tangent` to a perturbation that grows (`hbm/stability/perturbed_forces.py`).

    tangent: complex
    """
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider, out = new_slider(len(grid.share), n), new_scratch(len(grid.share), growing.weights)
    rows, own = rows_of(growing)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        press(coefficients[2], p, e, tables, pressing, rate, openings)
        closed = stays_closed(pressing)
        _write_normal_tangent(pressing, openings, kn, rows, growing.weights, out, tangent[e, 2], closed)
        ratio = hold(p, e, pressing, rate, path, openings)
        p_rows = limit_rows(p.mu[e], rows, growing.last_period, own)
        for d in range(2):
            slide(coefficients[d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            identity(out.by_u)
            out.by_p[:] = 0.0
            if not rests(path.u, grid.sample, slider.position):
                tell_apart(grid, path, ratio, slider)
                add_tangent(grid, path, rows, p_rows, ratio, slider, growing.weights, growing.last_period, out)
            write_tangential(kt, out.by_u, out.by_p, d, tangent[e, d])


@kept
def loop_areas(numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, areas: Any) -> None:
    """Writes (len(numbers),) areas of the force loops [J], of the forces at the samples."""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    force = np.empty(n + 1)
    slider = new_slider(len(grid.share), n)
    for i, e in enumerate(numbers):
        kt, kn = p.kt[e], p.kn[e]
        press(displacement[e, 2], p, e, tables, pressing, rate, openings)
        for t in range(n + 1):
            force[t] = kn * positive(pressing[t])
        areas[i] = loop_area(pressing, force)
        ratio = hold(p, e, pressing, rate, path, openings)
        for d in range(2):
            slide(displacement[e, d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            for t in range(n + 1):
                force[t] = kt * (path.u[t] - slider.position[grid.sample[t]])
            areas[i] += loop_area(path.u, force)


@kept
def contact_states(numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, states: Any) -> None:
    """Writes (len(numbers),) `observe.ContactState`: what each contact does over a period, between the samples too."""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider = new_slider(len(grid.share), n)
    for i, e in enumerate(numbers):
        press(displacement[e, 2], p, e, tables, pressing, rate, openings)
        ratio = hold(p, e, pressing, rate, path, openings)
        opens, closes, slips = False, False, False
        for d in range(2):
            slide(displacement[e, d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            least, position = SLIDER_STANDS * np.abs(path.u).max(), slider.position
            for k in range(grid.number[0]):
                opens, closes = opens or not grid.closed[k], closes or grid.closed[k]
                slips = slips or (grid.closed[k] and abs(position[k + 1] - position[k]) > least)
        states[i] = (2 if closes else 3) if opens else (1 if slips else 0)


@inner
def room(n: int, c: int) -> Any:
    return new_path(n), new_grid(n), new_openings(n), np.empty(n + 1), np.empty(n + 1), np.empty(c)


@inner
def rows_of(tables: Any) -> Any:
    """Of a motion, and room for those of a slip limit."""
    values = tables.values
    own = Rows(np.empty_like(values), np.empty_like(values), np.empty_like(values))
    return Rows(values, tables.slopes, tables.hats), own


@inner
def press(coefficients: Any, p: Any, e: int, tables: Tables, pressing: Any, rate: Any, openings: Any) -> None:
    """Writes the compression of element e, (n_time + 1,), its slope, and where it passes zero."""
    sample(coefficients, tables.synthesis, pressing)
    pressing += p.n0[e] / p.kn[e] - p.gap[e]
    slope(pressing, rate)
    find_openings(pressing, rate, openings)


@inner
def hold(p: Any, e: int, pressing: Any, rate: Any, path: Any, openings: Any) -> float:
    """Writes what sets the slip limit of element e, and its openings; returns as `set_limits`. openings: those of the
    compression, which they are where friction does not vary"""
    ratio = set_limits(p.mu[e], p.kn[e] / p.kt[e], pressing, path.p)
    path.dp[:] = rate
    if len(p.mu[e]) > 1:
        slope(path.p, path.dp)
        find_openings(path.p, path.dp, openings)
    return ratio


@inner
def slide(
    coefficients: Any,
    p: Any,
    e: int,
    d: int,
    tables: Tables,
    path: Any,
    ratio: float,
    openings: Any,
    cycles: int,
    grid: Any,
    slider: Any,
) -> None:
    """Writes the motion of element e in direction d, its nodes, and where the slider stands there."""
    sample(coefficients, tables.synthesis, path.u)
    slope(path.u, path.du)
    build_grid(path, ratio, openings, grid)
    march(grid, -p.t0[e, d] / p.kt[e], cycles, slider)


@inner
def _write_normal_tangent(
    pressing: Any, openings: Any, kn: float, rows: Rows, weights: Any, out: Any, tangent: Any, closed: bool
) -> None:
    """tangent: (n_coefficients, 3, n_coefficients); closed: whether the contact is taken to be so over the period"""
    tangent[:] = 0.0
    if not ever_closes(pressing, openings):
        return
    identity(out.by_u)
    if not closed:
        add_missing_tangent(pressing, openings, weights, rows, out.p, out.by_u)
    write_block(kn, out.by_u, tangent[:, 2, :])
