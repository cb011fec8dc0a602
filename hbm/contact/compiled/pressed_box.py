"""`PressureStiffness` of `JenkinsBox` for numba: the box law's samples times a power of its pressing force.

What the box law has between two samples is shared between them, as in `event_march.py`, before it is multiplied, and so
is the pressing force: these samples are linear in the integrals of the slider's path and of the compression, and so are
the changes of the coefficients of the product, by weights that are each element's own.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.at_rest import rests, stays_closed
from updamp.hbm.contact.compiled.by_friction import new_limit_rows, set_limit_rows, write_by_limit
from updamp.hbm.contact.compiled.columns import Rows
from updamp.hbm.contact.compiled.cubic import positive
from updamp.hbm.contact.compiled.event_grid import Openings
from updamp.hbm.contact.compiled.jenkins_box import hold, press, room, rows_of, slide
from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.normal import add_missing, add_missing_tangent, limit_rows
from updamp.hbm.contact.compiled.slider import Scratch, add_force, add_tangent, new_scratch, new_slider, tell_apart
from updamp.hbm.contact.compiled.tables import GrowingTables, Tables, loop_area

Floats = NDArray[np.float64]


class PressedBox(NamedTuple):
    """box: FrictionParameters of the law inside; exponent: (n_elements,) of its pressing force over `mean_force` [N]
    at_rest: (n_elements, 3) force at rest [N]"""

    box: Any
    exponent: Floats
    mean_force: Floats
    at_rest: Floats


class _Factor(NamedTuple):
    """Of one element. factor, slope: (n_time,) what the samples are multiplied by, and its derivative by the
    compression [1/m]; scaled: (n_time, n_coefficients) what a sample adds to the coefficients then; weights: (n_time +
    1, n_coefficients) what an integral against a hat adds to them; by_factor: (n_time, n_coefficients) what a change
    of the compression adds to them by the factor"""

    factor: Floats
    slope: Floats
    scaled: NDArray[Any]
    weights: NDArray[Any]
    by_factor: NDArray[Any]


class _Pressed(NamedTuple):
    """How one element is pressed. p: (n_time + 1,) compressions [m]; closed: whether throughout; rows, shares, sampled:
    of the motion or of what grows"""

    p: Floats
    openings: Openings
    closed: bool
    rows: Rows
    shares: NDArray[Any]
    sampled: NDArray[Any]


@kept
def force_with_tangent(
    numbers: Any, displacement: Any, p: PressedBox, cycles: int, sampled: Any, tables: Tables, force: Any, tangent: Any
) -> None:
    """As in jenkins_box.py beside this file. sampled: (n_time + 1, n_time) what integrals against hats add to the
    samples (`tables.sampled`)"""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider, out = new_slider(len(grid.share), n), new_scratch(len(grid.share), tables.weights)
    averaged, normal, by = np.empty(n), np.empty(n), _new_factor(n, tables.weights)
    rows, own = rows_of(tables)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.box.kt[e], p.box.kn[e]
        press(coefficients[2], p.box, e, tables, pressing, rate, openings)
        _average_normal(pressing, rate, openings, sampled, normal)
        _set_factor(normal, kn, p, e, sampled, tables.shares, by)
        _write_force(kn, normal, by.scaled, p.at_rest[e, 2], tables.constant, force[e, 2])
        closed = pressing.min() > 0 and openings.first.max() < 0
        pressed = _Pressed(pressing, _copy(openings), closed, rows, tables.shares, sampled)
        if len(tangent):
            _write_normal_tangent(pressed, kn, normal, by, out, tangent[e, 2])
        ratio = hold(p.box, e, pressing, rate, path, openings)
        p_rows = limit_rows(p.box.mu[e], rows, 1.0, own)
        for d in range(2):
            slide(coefficients[d], p.box, e, d, tables, path, ratio, openings, cycles, grid, slider)
            tell_apart(grid, path, ratio, slider)
            _average_slider(grid, path, ratio, slider, sampled, out, averaged)
            _write_force(kt, averaged, by.scaled, p.at_rest[e, d], tables.constant, force[e, d])
            if len(tangent):
                _set_springs(by.scaled, rows, out)
                add_tangent(grid, path, rows, p_rows, ratio, slider, by.weights, 1.0, out)
                _write_tangent(pressed, kt, averaged, by, out, d, tangent[e, d])


@kept
def perturbed_tangent(
    numbers: Any,
    displacement: Any,
    p: PressedBox,
    cycles: int,
    sampled: Any,
    tables: Tables,
    growing_sampled: Any,
    growing: GrowingTables,
    tangent: Any,
) -> None:
    """As in jenkins_box.py beside this file; growing_sampled: `sampled` of what grows"""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider, out = new_slider(len(grid.share), n), new_scratch(len(grid.share), growing.weights)
    averaged, normal, by = np.empty(n), np.empty(n), _new_factor(n, growing.weights)
    rows, own = rows_of(growing)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.box.kt[e], p.box.kn[e]
        press(coefficients[2], p.box, e, tables, pressing, rate, openings)
        _average_normal(pressing, rate, openings, sampled, normal)
        _set_factor(normal, kn, p, e, growing_sampled, growing.shares, by)
        closed = stays_closed(pressing)
        pressed = _Pressed(pressing, _copy(openings), closed, rows, growing.shares, growing_sampled)
        _write_normal_tangent(pressed, kn, normal, by, out, tangent[e, 2])
        ratio = hold(p.box, e, pressing, rate, path, openings)
        p_rows = limit_rows(p.box.mu[e], rows, growing.last_period, own)
        for d in range(2):
            slide(coefficients[d], p.box, e, d, tables, path, ratio, openings, cycles, grid, slider)
            tell_apart(grid, path, ratio, slider)
            _average_slider(grid, path, ratio, slider, sampled, out, averaged)
            _set_springs(by.scaled, rows, out)
            if not rests(path.u, grid.sample, slider.position):
                add_tangent(grid, path, rows, p_rows, ratio, slider, by.weights, growing.last_period, out)
            _write_tangent(pressed, kt, averaged, by, out, d, tangent[e, d])


@kept
def loop_areas(
    numbers: Any, displacement: Any, p: PressedBox, cycles: int, sampled: Any, tables: Tables, areas: Any
) -> None:
    """As in jenkins_box.py beside this file."""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    force, slider, by = np.empty(n + 1), new_slider(len(grid.share), n), _new_factor(n, tables.weights)
    for i, e in enumerate(numbers):
        kt, kn = p.box.kt[e], p.box.kn[e]
        press(displacement[e, 2], p.box, e, tables, pressing, rate, openings)
        _set_factor(pressing, kn, p, e, sampled, tables.shares, by)
        for t in range(n + 1):
            force[t] = kn * positive(pressing[t]) * by.factor[t % n]
        areas[i] = loop_area(pressing, force)
        ratio = hold(p.box, e, pressing, rate, path, openings)
        for d in range(2):
            slide(displacement[e, d], p.box, e, d, tables, path, ratio, openings, cycles, grid, slider)
            for t in range(n + 1):
                force[t] = kt * (path.u[t] - slider.position[grid.sample[t]]) * by.factor[t % n]
            areas[i] += loop_area(path.u, force)


@kept
def by_friction(
    numbers: Any, displacement: Any, p: PressedBox, cycles: int, sampled: Any, tables: Tables, mu_rows: Any, out: Any
) -> None:
    """As in by_friction.py beside this file; writes out, (len(numbers), 2, n_coefficients, m)."""
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider, scratch = new_slider(len(grid.share), n), new_scratch(len(grid.share), tables.weights)
    normal, by, of_limit = np.empty(n), _new_factor(n, tables.weights), new_limit_rows(n, mu_rows)
    for i, e in enumerate(numbers):
        press(displacement[e, 2], p.box, e, tables, pressing, rate, openings)
        _average_normal(pressing, rate, openings, sampled, normal)
        _set_factor(normal, p.box.kn[e], p, e, sampled, tables.shares, by)
        ratio = hold(p.box, e, pressing, rate, path, openings)
        set_limit_rows(pressing, mu_rows[i], of_limit)
        for d in range(2):
            slide(displacement[e, d], p.box, e, d, tables, path, ratio, openings, cycles, grid, slider)
            write_by_limit(grid, path, ratio, slider, by.weights, p.box.kt[e], of_limit, scratch, out[i, d])


@inner
def _copy(openings: Openings) -> Openings:
    """Of the compression: `hold` writes those of the slip limit in their place where friction varies."""
    return Openings(openings.first.copy(), openings.second.copy())


@inner
def _new_factor(n: int, weights: Any) -> _Factor:
    of_samples = np.empty_like(weights[:n])
    return _Factor(np.empty(n), np.empty(n), of_samples, np.empty_like(weights), np.empty_like(of_samples))


@inner
def _set_factor(pressing: Any, kn: float, p: PressedBox, e: int, sampled: Any, shares: Any, by: _Factor) -> None:
    """shares, sampled: as in tables, of the motion or of what grows"""
    n, exponent = len(by.factor), p.exponent[e]
    for t in range(n):
        by.factor[t] = by.slope[t] = 0.0
        if pressing[t] > 0:
            by.factor[t] = (kn * pressing[t] / p.mean_force[e]) ** exponent
            by.slope[t] = exponent * by.factor[t] / pressing[t]
        by.scaled[t] = by.factor[t] * shares[t]
    by.weights[:] = np.dot(sampled, by.scaled)


@inner
def _average_normal(pressing: Any, rate: Any, openings: Any, sampled: Any, averaged: Any) -> None:
    """Writes (n_time,) compressions where positive, what is between the samples shared between them [m]."""
    averaged[:] = pressing[: len(averaged)]
    add_missing(pressing, rate, openings, sampled, averaged)


@inner
def _average_slider(grid: Any, path: Any, ratio: float, slider: Any, sampled: Any, out: Scratch, averaged: Any) -> None:
    """Writes (n_time,) the force in one direction over kt, likewise [m]."""
    averaged[:] = path.u[: len(averaged)]
    at_samples = Scratch(averaged, out.by_u, out.by_p, out.integrals, out.sources, out.used, out.u, out.p)
    add_force(grid, path, ratio, slider, sampled, at_samples)


@inner
def _write_force(stiffness: float, averaged: Any, scaled: Any, at_rest: float, constant: Any, force: Any) -> None:
    for a in range(len(force)):
        total = 0.0
        for t in range(len(averaged)):
            total += scaled[t, a] * averaged[t]
        force[a] = stiffness * total - at_rest * constant[a]


@inner
def _set_springs(scaled: Any, rows: Rows, out: Scratch) -> None:
    """Derivatives of what springs that never slip or open would have, over their stiffness."""
    out.by_u[:] = np.dot(scaled.T, rows.values[: len(scaled)])
    out.by_p[:] = 0.0


@inner
def _write_normal_tangent(pressed: Any, kn: float, normal: Any, by: _Factor, out: Scratch, tangent: Any) -> None:
    """As in jenkins_box.py beside this file."""
    _set_springs(by.scaled, pressed.rows, out)
    if not pressed.closed:
        add_missing_tangent(pressed.p, pressed.openings, by.weights, pressed.rows, out.p, out.by_u)
    _write_tangent(pressed, kn, normal, by, out, 2, tangent)


@inner
def _write_tangent(
    pressed: Any, stiffness: float, averaged: Any, by: _Factor, out: Scratch, d: int, tangent: Any
) -> None:
    """Writes tangent, (n_coefficients, 3, n_coefficients), of the force in direction d; out.by_u, out.by_p: derivatives
    by the motion in it and by the compression with the factor held"""
    for t in range(len(averaged)):
        by.by_factor[t] = averaged[t] * by.slope[t] * pressed.shares[t]
    out.by_p[:] += np.dot(by.by_factor.T, pressed.rows.values[: len(averaged)])
    if not pressed.closed:
        weights = np.dot(pressed.sampled, by.by_factor)
        add_missing_tangent(pressed.p, pressed.openings, weights, pressed.rows, out.p, out.by_p)
    tangent[:] = 0.0
    for a in range(len(out.by_u)):
        for b in range(len(out.by_u)):
            tangent[a, d, b] += stiffness * out.by_u[a, b]
            tangent[a, 2, b] += stiffness * out.by_p[a, b]
