"""`JenkinsBox` for numba: elements one by one, events between the samples (`event_march.py`, which defines it)."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.at_rest import rests, stays_closed
from updamp.hbm.contact.compiled.keeping import kept
from updamp.hbm.contact.compiled.normal import (
    identity,
    set_limits,
    write_normal,
    write_normal_tangent,
    write_tangential,
)
from updamp.hbm.contact.compiled.segments import positive
from updamp.hbm.contact.compiled.slider import (
    Rows,
    add_force,
    add_tangent,
    find_corners,
    march,
    new_path,
    new_scratch,
    new_slider,
)
from updamp.hbm.contact.compiled.tables import GrowingTables, Tables, loop_area, sample, slope


@kept
def force_with_tangent(
    numbers: Any, displacement: Any, p: Any, cycles: int, most: Any, tables: Tables, force: Any, tangent: Any
) -> None:
    """Writes force (n_elements, 3, n_coefficients) [N] of the elements of these numbers, and tangent (n_elements, 3,
    n_coefficients, 3, n_coefficients) [N/m] unless that has no elements.

    displacement: like force [m]; p: FrictionParameters, mu of shape (n_elements, 1), or (n_elements, n_time) where it
        varies over the period
    most: corners that are followed of the path, and of where it was pushed to (`event_march.most_corners`)
    """
    c, n = tables.synthesis.shape
    slider, path, out, pressing = new_slider(tables.shares), new_path(n), new_scratch(tables.shares), np.empty(n + 1)
    rows = Rows(tables.values, tables.slopes, tables.values.copy())
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        sample(coefficients[2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        write_normal(coefficients[2], pressing, p, e, most[0], tables, force, tangent, out.by_u)
        ratio = set_limits(p.mu[e], kn / kt, pressing, tables.values, path.p, rows.p)
        for d in range(2):
            sample(coefficients[d], tables.synthesis, path.u)
            slope(path.u, path.du)
            march(path, ratio, -p.t0[e, d] / kt, cycles, most[1], slider)
            find_corners(path, ratio, most[0], slider)
            out.force[:] = coefficients[d]
            add_force(path, ratio, slider, tables.shares, out.force)
            for a in range(c):
                force[e, d, a] = kt * out.force[a] - p.t0[e, d] * tables.constant[a]
            if len(tangent):
                identity(out.by_u)
                out.by_p[:] = 0.0
                add_tangent(path, rows, ratio, slider, tables.shares, 1.0, out)
                write_tangential(kt, out.by_u, out.by_p, d, tangent[e, d])


@kept
def perturbed_tangent(
    numbers: Any,
    displacement: Any,
    p: Any,
    cycles: int,
    most: Any,
    tables: Tables,
    growing: GrowingTables,
    tangent: Any,
) -> None:
    """Writes the tangent of `force_with_tangent` to a perturbation that grows (`hbm/stability/perturbed_forces.py`).

    tangent: complex
    """
    n = tables.synthesis.shape[1]
    slider, path, out = new_slider(growing.shares), new_path(n), new_scratch(growing.shares)
    pressing, rows = np.empty(n + 1), Rows(growing.values, growing.slopes, growing.values.copy())
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        sample(coefficients[2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        write_normal_tangent(pressing, kn, most[0], growing, tangent[e, 2], out.by_u, stays_closed(pressing))
        ratio = set_limits(p.mu[e], kn / kt, pressing, growing.values, path.p, rows.p)
        for d in range(2):
            sample(coefficients[d], tables.synthesis, path.u)
            slope(path.u, path.du)
            march(path, ratio, -p.t0[e, d] / kt, cycles, most[1], slider)
            find_corners(path, ratio, most[0], slider)
            identity(out.by_u)
            out.by_p[:] = 0.0
            if not rests(path.u, slider.source, slider.position):
                add_tangent(path, rows, ratio, slider, growing.shares, growing.last_period, out)
            write_tangential(kt, out.by_u, out.by_p, d, tangent[e, d])


@kept
def loop_areas(numbers: Any, displacement: Any, p: Any, cycles: int, most: Any, tables: Tables, areas: Any) -> None:
    """Writes (len(numbers),) areas of the force loops [J], of the forces at the samples."""
    n = tables.synthesis.shape[1]
    slider, path, pressing, force = new_slider(tables.shares), new_path(n), np.empty(n + 1), np.empty(n + 1)
    p_rows = tables.values.copy()
    for i, e in enumerate(numbers):
        kt, kn = p.kt[e], p.kn[e]
        sample(displacement[e, 2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        for t in range(n + 1):
            force[t] = kn * positive(pressing[t])
        areas[i] = loop_area(pressing, force)
        ratio = set_limits(p.mu[e], kn / kt, pressing, tables.values, path.p, p_rows)
        for d in range(2):
            sample(displacement[e, d], tables.synthesis, path.u)
            slope(path.u, path.du)
            march(path, ratio, -p.t0[e, d] / kt, cycles, most[1], slider)
            for t in range(n + 1):
                force[t] = kt * (path.u[t] - slider.position[slider.source[t]])
            areas[i] += loop_area(path.u, force)
