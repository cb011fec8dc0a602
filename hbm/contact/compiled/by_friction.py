"""Derivatives of `JenkinsBox`'s friction forces by a friction coefficient that varies over the period."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.columns import Rows, multiply
from updamp.hbm.contact.compiled.jenkins_box import hold, press, room, slide
from updamp.hbm.contact.compiled.keeping import kept
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
    values = np.empty((n + 1, mu_rows.shape[2]))
    of_limit = Rows(values, np.empty_like(values), np.empty_like(values))
    for i, e in enumerate(numbers):
        press(displacement[e, 2], p, e, tables, pressing, rate, openings)
        ratio = hold(p, e, pressing, rate, path, openings)
        for t in range(n + 1):
            values[t] = pressing[t] * mu_rows[i, t % n]
        slope_rows(values, 1.0, of_limit.slopes)
        hat_rows(values, of_limit.slopes, 1.0, of_limit.hats)
        derivative[i] = 0.0
        for d in range(2):
            slide(displacement[e, d], p, e, d, tables, path, ratio, openings, cycles, grid, slider)
            tell_apart(grid, path, ratio, slider)
            gather_tangent(grid, path, ratio, slider, tables.weights, 1.0, out)
            multiply(out.p, of_limit, derivative[i, d])
            derivative[i, d] *= p.kt[e]
