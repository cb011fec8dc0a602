"""Derivatives of `JenkinsBox`'s friction forces by a friction coefficient that varies over the period."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.columns import Rows, multiply
from updamp.hbm.contact.compiled.jenkins_box import hold, press, room, slide
from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.slider import gather_tangent, new_scratch, new_slider, tell_apart
from updamp.hbm.contact.compiled.tables import Tables, hat_rows, slope_rows


@kept
def by_friction(
    numbers: Any, displacement: Any, p: Any, cycles: int, tables: Tables, mu_rows: Any, derivative: Any
) -> None:
    """Writes derivative, (len(numbers), 2, n_coefficients, m), of the coefficients of the forces in t1 and t2 by m
    numbers that the friction coefficient depends on.

    p: FrictionParameters, mu of shape (n_elements, n_time); mu_rows: (len(numbers), n_time, m) derivatives of mu
    """
    c, n = tables.synthesis.shape
    path, grid, openings, pressing, rate, _ = room(n, c)
    slider, out = new_slider(len(grid.share), n), new_scratch(len(grid.share), tables.weights)
    of_limit = new_limit_rows(n, mu_rows)
    for i, e in enumerate(numbers):
        press(displacement[e, 2], p, e, tables, pressing, rate, openings)
        ratio = hold(p, e, pressing, rate, path, openings)
        set_limit_rows(pressing, mu_rows[i], of_limit)
        for d in range(2):
            slide(displacement[e, d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            write_by_limit(grid, path, ratio, slider, tables.weights, p.kt[e], of_limit, out, derivative[i, d])


@inner
def new_limit_rows(n: int, mu_rows: Any) -> Rows:
    values = np.empty((n + 1, mu_rows.shape[2]))
    return Rows(values, np.empty_like(values), np.empty_like(values))


@inner
def set_limit_rows(pressing: Any, mu_rows: Any, of_limit: Rows) -> None:
    """Of what sets the slip limit (`normal.set_limits`); mu_rows: (n_time, m) of one element"""
    for t in range(len(of_limit.values)):
        of_limit.values[t] = pressing[t] * mu_rows[t % len(mu_rows)]
    slope_rows(of_limit.values, 1.0, of_limit.slopes)
    hat_rows(of_limit.values, of_limit.slopes, 1.0, of_limit.hats)


@inner
def write_by_limit(
    grid: Any, path: Any, ratio: float, slider: Any, weights: Any, kt: float, of_limit: Rows, out: Any, derivative: Any
) -> None:
    """Writes derivative, (n_coefficients, m), of the force in one direction; weights: as in `add_force`"""
    tell_apart(grid, path, ratio, slider)
    gather_tangent(grid, path, ratio, slider, weights, 1.0, out)
    derivative[:] = 0.0
    multiply(out.p, of_limit, derivative)
    derivative *= kt
