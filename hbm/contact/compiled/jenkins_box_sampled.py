"""`SampledJenkinsBox` for numba: elements one by one, events at the samples.

The slider stands where one sample put it, its source, so that the tangent is a sum over sources (see slider.py).
"""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.at_rest import rests, stays_closed
from updamp.hbm.contact.compiled.cubic import positive
from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.normal import (
    add_missing_samples,
    add_missing_samples_tangent,
    identity,
    set_limits,
    write_block,
    write_normal,
    write_tangential,
)
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
    numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, force: Any, tangent: Any
) -> None:
    """As in jenkins_box.py beside this file."""
    c, n = tables.synthesis.shape
    pressing, u, limit = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    position, source = np.empty(n), np.empty(n, dtype=np.int64)
    by_u, by_p, columns = np.empty((c, c)), np.empty((c, c)), (np.empty((n + 1, c)), np.empty((n + 1, c)))
    p_rows, missing = tables.values.copy(), np.empty(c)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        sample(coefficients[2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        missing[:] = 0.0
        add_missing_samples(pressing, tables.shares, missing)
        presses, rest = pressing.max() > 0, p.n0[e] - kn * p.gap[e]
        write_normal(presses, missing, coefficients[2], rest, kn, tables.constant, force[e, 2])
        if len(tangent):
            _write_normal_tangent(pressing, kn, tables, by_u, tangent[e, 2], False)
        ratio = set_limits(p.mu[e], kn / kt, pressing, limit)
        _write_limit_rows(p.mu[e], tables.values, p_rows)
        for t in range(n):
            limit[t] = ratio * positive(limit[t])
        for d in range(2):
            sample(coefficients[d], tables.synthesis, u)
            _march(u, limit, -p.t0[e, d] / kt, cycles, position, source)
            for a in range(c):
                taken = 0.0
                for t in range(n):
                    taken += tables.shares[t, a] * position[t]
                force[e, d, a] = kt * (coefficients[d, a] - taken) - p.t0[e, d] * tables.constant[a]
            if len(tangent):
                identity(by_u)
                by_p[:] = 0.0
                _add_tangent(source, limit, ratio, tables, p_rows, 1.0, by_u, by_p, columns)
                write_tangential(kt, by_u, by_p, d, tangent[e, d])


@kept
def perturbed_tangent(
    numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, growing: GrowingTables, tangent: Any
) -> None:
    """As in jenkins_box.py beside this file."""
    c, n = tables.synthesis.shape
    pressing, u, limit = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    position, source, kind = np.empty(n), np.empty(n, dtype=np.int64), growing.shares.dtype
    by_u, by_p = np.empty((c, c), kind), np.empty((c, c), kind)
    columns, p_rows = (np.empty((n + 1, c), kind), np.empty((n + 1, c), kind)), growing.values.copy()
    samples = np.arange(n)
    for e in numbers:
        coefficients, kt, kn = displacement[e], p.kt[e], p.kn[e]
        sample(coefficients[2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        _write_normal_tangent(pressing, kn, growing, by_u, tangent[e, 2], stays_closed(pressing))
        ratio = set_limits(p.mu[e], kn / kt, pressing, limit)
        _write_limit_rows(p.mu[e], growing.values, p_rows)
        for t in range(n):
            limit[t] = ratio * positive(limit[t])
        for d in range(2):
            sample(coefficients[d], tables.synthesis, u)
            _march(u, limit, -p.t0[e, d] / kt, cycles, position, source)
            identity(by_u)
            by_p[:] = 0.0
            if not rests(u, samples, position):
                _add_tangent(source, limit, ratio, growing, p_rows, growing.last_period, by_u, by_p, columns)
            write_tangential(kt, by_u, by_p, d, tangent[e, d])


@kept
def loop_areas(numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, areas: Any) -> None:
    """As in jenkins_box.py beside this file."""
    n = tables.synthesis.shape[1]
    pressing, u, force, limit = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    position, source = np.empty(n), np.empty(n, dtype=np.int64)
    for i, e in enumerate(numbers):
        kt, kn = p.kt[e], p.kn[e]
        sample(displacement[e, 2], tables.synthesis, pressing)
        pressing += p.n0[e] / kn - p.gap[e]
        ratio = set_limits(p.mu[e], kn / kt, pressing, limit)
        for t in range(n + 1):
            limit[t], force[t] = ratio * positive(limit[t]), kn * positive(pressing[t])
        areas[i] = loop_area(pressing, force)
        for d in range(2):
            sample(displacement[e, d], tables.synthesis, u)
            _march(u, limit, -p.t0[e, d] / kt, cycles, position, source)
            for t in range(n + 1):
                force[t] = kt * (u[t] - position[t % n])
            areas[i] += loop_area(u, force)


@inner
def _write_normal_tangent(pressing: Any, kn: float, tables: Any, by_p: Any, tangent: Any, closed: bool) -> None:
    """As in jenkins_box.py beside this file; by_p: (n_coefficients, n_coefficients), scratch"""
    tangent[:] = 0.0
    if pressing.max() <= 0:
        return
    identity(by_p)
    if not closed:
        add_missing_samples_tangent(pressing, tables.shares, tables.values, by_p)
    write_block(kn, by_p, tangent[:, 2, :])


@inner
def _write_limit_rows(mu: Any, values: Any, p_rows: Any) -> None:
    """Derivatives of what sets the slip limit (`normal.set_limits`); p_rows: those of the compression at first"""
    if len(mu) > 1:
        for t in range(len(values)):
            for a in range(values.shape[1]):
                p_rows[t, a] = mu[t % len(mu)] * values[t, a]


@inner
def _march(u: Any, limit: Any, first: float, cycles: int, position: Any, source: Any) -> None:
    """Writes, for each sample, where the slider stands [m] and its source: the sample that pushed it up to
    there, n_time more for one that pushed it down, 2 n_time where it stands as at first.

    limit: slip limit over kt [m]; where it is zero the slider goes along
    """
    n = len(source)
    stands, number = first, 2 * n
    for _ in range(cycles):
        for t in range(n):
            if u[t] - stands > limit[t] or limit[t] == 0:
                stands, number = u[t] - limit[t], t
            elif u[t] - stands < -limit[t]:
                stands, number = u[t] + limit[t], n + t
            position[t], source[t] = stands, number


@inner
def _add_tangent(
    source: Any,
    limit: Any,
    ratio: float,
    tables: Any,
    p_rows: Any,
    last_period: Any,
    by_u: Any,
    by_p: Any,
    columns: Any,
) -> None:
    """Adds the derivatives of what the slider takes away; columns: scratch, two of (n_time + 1, n_coefficients)

    last_period: as in slider.py
    """
    n, (columns_u, columns_p) = len(source), columns
    columns_u[:], columns_p[:] = 0.0, 0.0
    for t in range(n):
        at = source[t] % n
        if source[t] == 2 * n:
            continue
        by_limit = 0.0 if limit[at] == 0 else (ratio if source[t] < n else -ratio)
        size = size_of_change(at > t, last_period)
        for a in range(columns_u.shape[1]):
            columns_u[at, a] -= size * tables.shares[t, a]
            columns_p[at, a] += by_limit * size * tables.shares[t, a]
    add_products(columns_u, tables.values, by_u)
    add_products(columns_p, p_rows, by_p)
