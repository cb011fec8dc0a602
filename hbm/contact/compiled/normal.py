"""The unilateral normal spring of both box laws, and what sets their slip limit."""

from typing import Any

from updamp.hbm.contact.compiled.columns import Columns, Rows, add_numbers, empty, multiply
from updamp.hbm.contact.compiled.cubic import basis_halves, halves, positive
from updamp.hbm.contact.compiled.event_grid import Openings, compression_of, parts
from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.tables import add_outer, hat_rows, slope_rows


@inner
def write_normal(
    presses: bool, missing: Any, coefficients: Any, rest: float, kn: float, constant: Any, out: Any
) -> None:
    """Writes the normal force, (n_coefficients,) [N], of a motion of these coefficients [m].

    presses: whether the contact closes at any time; missing: coefficients of what a spring that always presses has less
    while the contact is open, over kn (`add_missing`); rest: n0 - kn gap [N]; constant: as in `Tables`
    """
    for a in range(len(out)):
        if not presses:  # exactly nothing, where the difference leaves round-off
            out[a] = -positive(rest) * constant[a]
        else:
            out[a] = kn * (coefficients[a] + missing[a]) + (rest - positive(rest)) * constant[a]


@inner
def ever_closes(p: Any, openings: Openings) -> bool:
    """Whether the contact is closed at any time, if only between two samples."""
    return p.max() > 0 or openings.first.max() >= 0


@inner
def add_missing(p: Any, dp: Any, openings: Openings, weights: Any, out: Any) -> None:
    """p, dp: (n_time + 1,) compression and its slope; out: (n_coefficients,)"""
    for j in range(len(p) - 1):
        part = parts(not p[j] > 0, openings.first[j], openings.second[j])
        for begin, end in ((part[0], part[1]), (part[2], part[3])):
            if end > begin:
                start, after = halves(compression_of(p, dp, j), begin, end)
                for a in range(len(out)):
                    out[a] -= weights[j, a] * start + weights[j + 1, a] * after


@inner
def add_missing_tangent(p: Any, openings: Openings, weights: Any, rows: Rows, columns: Columns, by_p: Any) -> None:
    """Derivatives of what `add_missing` adds; rows: of the compression"""
    n = len(p) - 1
    empty(columns)
    for j in range(n):
        part = parts(not p[j] > 0, openings.first[j], openings.second[j])
        before = _whole(p, openings, j) and _whole(p, openings, (j - 1) % n)
        if before:  # open on both sides of the sample: the hat is one
            for a in range(len(by_p)):
                columns.hats[j, a] -= weights[j, a]
        for begin, end in ((part[0], part[1]), (part[2], part[3])):
            if end > begin:
                by = basis_halves(begin, end)
                if not before:
                    add_numbers(by[0], j, -1.0, weights[j], columns)
                if not (_whole(p, openings, j) and _whole(p, openings, (j + 1) % n)):
                    add_numbers(by[1], j, -1.0, weights[j + 1], columns)
    multiply(columns, rows, by_p)


@inner
def _whole(p: Any, openings: Openings, j: int) -> bool:
    """Whether the contact is open throughout the segment."""
    return not p[j] > 0 and openings.first[j] < 0


@inner
def add_missing_samples(p: Any, shares: Any, out: Any) -> None:
    """As `add_missing`, of the samples alone."""
    for j in range(len(p) - 1):
        if p[j] < 0:
            for a in range(len(out)):
                out[a] -= shares[j, a] * p[j]


@inner
def add_missing_samples_tangent(p: Any, shares: Any, values: Any, by_p: Any) -> None:
    """Derivatives of what `add_missing_samples` adds, at 0 the mean of both sides, as JAX has it."""
    for j in range(len(p) - 1):
        if not p[j] > 0:
            add_outer(shares[j], -1.0 if p[j] < 0 else -0.5, values[j], by_p)


@inner
def limit_rows(mu: Any, of_pressing: Rows, last_period: Any, own: Rows) -> Rows:
    """Rows of what sets the slip limit, `set_limits`: those of the compression, or own ones where friction varies."""
    if len(mu) == 1:
        return of_pressing
    n = len(mu)
    for t in range(n + 1):
        for a in range(own.values.shape[1]):
            own.values[t, a] = mu[t % n] * of_pressing.values[t, a]
    slope_rows(own.values, last_period, own.slopes)
    hat_rows(own.values, own.slopes, last_period, own.hats)
    return own


@inner
def set_limits(mu: Any, ratio: float, pressing: Any, p: Any) -> float:
    """Writes compressions p, (n_time + 1,), and returns what p is multiplied by for the slip limit over kt
    (`event_march._friction`).

    mu: (1,), or (n_time,) where friction varies over the period; ratio: kn / kt
    """
    if len(mu) == 1:
        p[:] = pressing
        return ratio * mu[0]
    n = len(mu)
    for t in range(n + 1):
        p[t] = mu[t % n] * pressing[t]
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
