"""The unilateral normal spring of both box laws, and what sets their slip limit."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled.corners import contact_corner, contact_corner_slopes
from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.segments import positive, positive_slope
from updamp.hbm.contact.compiled.tables import Tables, add_outer, add_products


@inner
def write_normal(
    coefficients: Any, pressing: Any, p: Any, e: int, most: int, tables: Tables, force: Any, tangent: Any, scratch: Any
) -> None:
    """Writes the normal force of element e and its tangent, as `force_with_tangent` in jenkins_box.py beside this file.

    pressing: (n_time + 1,) compression [m]; most: corners followed between the samples, 0 for none
    scratch: (n_coefficients, n_coefficients)
    """
    kn, rest = p.kn[e], p.n0[e] - p.kn[e] * p.gap[e]
    out = force[e, 2]
    if pressing.max() <= 0:  # open throughout: exactly nothing, where the difference below leaves round-off
        for a in range(len(out)):
            out[a] = -positive(rest) * tables.constant[a]
        if len(tangent):
            tangent[e, 2] = 0.0
        return
    for a in range(len(out)):
        out[a] = coefficients[a] + (rest - positive(rest)) / kn * tables.constant[a]
    _add_openings(pressing, tables.shares, most, out)
    for a in range(len(out)):
        out[a] *= kn
    if len(tangent):
        write_normal_tangent(pressing, kn, most, tables, tangent[e, 2], scratch, False)


@inner
def write_normal_tangent(
    pressing: Any, kn: float, most: int, tables: Any, tangent: Any, scratch: Any, closed: bool
) -> None:
    """Writes tangent, (n_coefficients, 3, n_coefficients), as `write_normal`; tables: `Tables` or `GrowingTables`

    closed: whether the contact is taken to be so over the whole period
    """
    tangent[:] = 0.0
    if pressing.max() <= 0:
        return
    identity(scratch)
    if not closed:
        _add_openings_tangent(pressing, tables, most, scratch)
    write_block(kn, scratch, tangent[:, 2, :])


@inner
def _add_openings(p: Any, shares: Any, most: int, force: Any) -> None:
    """Adds to the force of a spring that always presses, over kn, what is missing while the contact is open."""
    found = 0
    for j in range(len(p) - 1):
        if p[j] < 0:
            for a in range(len(force)):
                force[a] -= shares[j, a] * p[j]
        if (p[j] > 0) != (p[j + 1] > 0) and found < most:
            found += 1
            integral, moment = contact_corner(p[j], p[j + 1])
            for a in range(len(force)):
                force[a] += shares[j, a] * (integral - moment) + shares[j + 1, a] * moment


@inner
def _add_openings_tangent(p: Any, tables: Any, most: int, by_p: Any) -> None:
    """Derivatives of what `_add_openings` adds."""
    shares, values = tables.shares, tables.values
    found, missing = 0, np.zeros(shares.shape, shares.dtype)
    for j in range(len(p) - 1):
        for a in range(shares.shape[1]):
            missing[j, a] = (positive_slope(p[j]) - 1) * shares[j, a]
        if (p[j] > 0) != (p[j + 1] > 0) and found < most:
            found += 1
            integral, moment = contact_corner_slopes(p[j], p[j + 1])
            for q in range(2):
                add_outer(shares[j], integral[q] - moment[q], values[j + q], by_p)
                add_outer(shares[j + 1], moment[q], values[j + q], by_p)
    add_products(missing, values, by_p)


@inner
def set_limits(mu: Any, ratio: float, pressing: Any, values: Any, p: Any, by_p: Any) -> float:
    """Writes compressions p, (n_time + 1,), and their derivatives by_p by the coefficients, (n_time + 1,
    n_coefficients), and returns what p is multiplied by for the slip limit over kt (`event_march._friction`).

    mu: (1,), or (n_time,) where friction varies over the period; values: derivatives of `pressing`, as which by_p comes
    ratio: kn / kt
    """
    if len(mu) == 1:
        p[:] = pressing
        return ratio * mu[0]
    n = len(mu)
    for t in range(n + 1):
        p[t] = mu[t % n] * pressing[t]
        for a in range(by_p.shape[1]):
            by_p[t, a] = mu[t % n] * values[t, a]
    return ratio


@inner
def identity(out: Any) -> None:
    out[:] = 0.0
    for a in range(len(out)):
        out[a, a] = 1.0


@inner
def write_tangential(kt: float, by_u: Any, by_p: Any, d: int, tangent: Any) -> None:
    """Writes tangent, (n_coefficients, 3, n_coefficients), of the force in direction d; by_u, by_p: over kt"""
    tangent[:] = 0.0
    write_block(kt, by_u, tangent[:, d, :])
    write_block(kt, by_p, tangent[:, 2, :])


@inner
def write_block(factor: float, block: Any, out: Any) -> None:
    for a in range(block.shape[0]):
        for b in range(block.shape[1]):
            out[a, b] = factor * block[a, b]
