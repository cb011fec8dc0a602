"""The march of a slider through its segments, and its force's Fourier coefficients with their tangent.

A slider always stands where one segment put it, its source. So the tangent is a sum over sources: what the samples of
that source add to the coefficients, times the derivatives of the one position. Beside it there are the few segments
with a corner, which have a share of their own.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.corners import corner, corner_slopes
from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.segments import (
    DU0,
    DU1,
    N_CORNER,
    P0,
    P1,
    U0,
    U1,
    W0,
    W1,
    end_of,
    has_corner,
    positive,
    positive_slope,
    push,
    push_slopes,
    turned,
)
from updamp.hbm.contact.compiled.tables import add_outer, add_products, size_of_change

Floats = NDArray[np.float64]


class Path(NamedTuple):
    """Motion at the samples, all (n_time + 1,): u of the spring's end [m] and its slope du a sample, p the compression
    that sets the limit [m] (`event_march._friction`)."""

    u: Floats
    du: Floats
    p: Floats


class Slider(NamedTuple):
    """source: (n_time + 1,) where the slider stands at each sample: pushed up by the segment of this number, down from
    n_time on, at first at 2 n_time
    position: (2 n_time + 1,) of each source in use [m]; inside: whether it lies within the segment, not at its end
    up, down: (n_time,) where each segment pushes to [m]; corner: whether its path is followed between the samples
    columns: (2 n_time + 1, n_coefficients) what the samples of each source add to the coefficients
    ends_u, ends_p: (n_time + 1, n_coefficients) the same of those that stand where the segment ends, at this sample,
        times the derivatives of their position by u and p there
    """

    source: NDArray[np.int64]
    position: Floats
    inside: NDArray[np.bool_]
    up: Floats
    down: Floats
    corner: NDArray[np.bool_]
    columns: Floats
    ends_u: Floats
    ends_p: Floats


class Rows(NamedTuple):
    """Derivatives of u, du and p by the coefficients, each (n_time + 1, n_coefficients), real or complex."""

    u: NDArray[Any]
    du: NDArray[Any]
    p: NDArray[Any]


class Scratch(NamedTuple):
    """Of one direction. force: (n_coefficients,) [m], over kt; by_u, by_p: its derivatives (n_coefficients,
    n_coefficients); row_u, row_p: (n_coefficients,); by: (2, N_CORNER)"""

    force: Floats
    by_u: Floats
    by_p: Floats
    row_u: Floats
    row_p: Floats
    by: Floats


@inner
def new_path(n: int) -> Path:
    return Path(np.empty(n + 1), np.empty(n + 1), np.empty(n + 1))


@inner
def new_slider(shares: Any) -> Slider:
    """shares: (n_time + 1, n_coefficients); what belongs to tangents is of their kind of numbers"""
    n, c, kind = len(shares) - 1, shares.shape[1], shares.dtype
    source, inside = np.empty(n + 1, dtype=np.int64), np.empty(2 * n + 1, dtype=np.bool_)
    columns = np.empty((2 * n + 1, c), kind)
    ends_u, ends_p = np.empty((n + 1, c), kind), np.empty((n + 1, c), kind)
    up, down, corners = np.empty(n), np.empty(n), np.empty(n, dtype=np.bool_)
    return Slider(source, np.empty(2 * n + 1), inside, up, down, corners, columns, ends_u, ends_p)


@inner
def new_scratch(shares: Any) -> Scratch:
    c, kind = shares.shape[1], shares.dtype
    square, row = np.empty((c, c), kind), np.empty(c, kind)
    return Scratch(np.empty(c), square, square.copy(), row, row.copy(), np.empty((2, N_CORNER)))


@inner
def segment(path: Path, j: int) -> Any:
    """See `segments.py`."""
    u, du, p = path
    return u[j], u[j + 1], du[j], du[j + 1], p[j], p[j + 1]


@inner
def march(path: Path, ratio: float, first: float, cycles: int, most: int, slider: Slider) -> None:
    """As `event_march._sliders`; most: sources within their segment that are followed, the others are taken at its
    end."""
    n = len(slider.up)
    for j in range(n):
        s = segment(path, j)
        slider.up[j], slider.down[j] = push(s, ratio), -push(turned(s, -1.0), ratio)
    bound = ratio * positive(path.p[0])
    stands = min(max(first, path.u[0] - bound), path.u[0] + bound)
    number = n - 1 if stands > first else (2 * n - 1 if stands < first else 2 * n)
    for _ in range(cycles):
        for j in range(n):
            slider.source[j] = number
            up, down = slider.up[j], slider.down[j]
            if path.p[j] <= 0 and path.p[j + 1] > 0:
                stands, number = up, j
                continue
            if stands < up:
                stands, number = up, j
            if stands > down:
                stands, number = down, n + j
    slider.source[n] = slider.source[0]
    slider.position[2 * n] = first
    _place(path, ratio, most, slider)


@inner
def _place(path: Path, ratio: float, most: int, slider: Slider) -> None:
    """Positions of the sources in use; those within their segment are counted in the order of their numbers."""
    n = len(slider.up)
    # until the number is known, `inside` says which are in use
    slider.inside[:] = False
    for j in range(n):
        slider.inside[slider.source[j]] = True
    slider.inside[2 * n] = False
    found = 0
    for k in range(2 * n):
        if not slider.inside[k]:
            continue
        sign, j = (1.0, k) if k < n else (-1.0, k - n)
        end = end_of(turned(segment(path, j), sign), ratio)
        pushed = slider.up[j] if k < n else -slider.down[j]
        inside = pushed > end and found < most
        found += inside
        slider.inside[k] = inside
        slider.position[k] = sign * (pushed if inside else end)


@inner
def find_corners(path: Path, ratio: float, most: int, slider: Slider) -> None:
    """Writes slider.corner; most: corners that are followed."""
    found = 0
    for j in range(len(slider.up)):
        w0 = slider.position[slider.source[j]]
        slider.corner[j] = found < most and has_corner(segment(path, j), ratio, w0, slider.up[j], slider.down[j])
        found += slider.corner[j]


@inner
def add_force(path: Path, ratio: float, slider: Slider, shares: Floats, force: Floats) -> None:
    """Adds to the force of a spring alone, over kt, what the slider takes away and what lies beyond the chords."""
    for j in range(len(slider.up)):
        w0 = slider.position[slider.source[j]]
        for a in range(len(force)):
            force[a] -= shares[j, a] * w0
        if slider.corner[j]:
            integral, moment = corner(segment(path, j), ratio, w0, slider.position[slider.source[j + 1]])
            for a in range(len(force)):
                force[a] += shares[j, a] * (integral - moment) + shares[j + 1, a] * moment


@inner
def add_tangent(
    path: Path, rows: Rows, ratio: float, slider: Slider, shares: Any, last_period: Any, out: Scratch
) -> None:
    """Adds to out.by_u and out.by_p the derivatives of what `add_force` has added.

    last_period: factor of what moved the slider in the period before (1 where the motion's change is periodic)
    """
    n = len(slider.up)
    slider.columns[:] = 0.0
    for j in range(n):
        k, following = slider.source[j], slider.source[j + 1]
        # a source moves the slider in a segment that comes later only if that lies in the period before
        size0 = size_of_change(k % n >= j, last_period)
        size1 = size_of_change(following % n >= j + 1, last_period)
        for a in range(len(out.force)):
            slider.columns[k, a] += size0 * shares[j, a]
        s, w0 = segment(path, j), slider.position[k]
        if slider.corner[j]:
            corner_slopes(s, ratio, w0, slider.position[following], out.by)
            for a in range(N_CORNER):
                out.by[0, a] -= out.by[1, a]  # the start has the integral less the moment
            for q in range(2):
                for a in range(len(out.force)):
                    slider.columns[k, a] -= size0 * shares[j + q, a] * out.by[q, W0]
                    slider.columns[following, a] -= size1 * shares[j + q, a] * out.by[q, W1]
                _add(shares[j + q], 1.0, out.by[q], rows, j, out)
    _add_sources(path, rows, ratio, slider, out)


@inner
def _add_sources(path: Path, rows: Rows, ratio: float, slider: Slider, out: Scratch) -> None:
    n = len(slider.up)
    slider.ends_u[:], slider.ends_p[:] = 0.0, 0.0
    # a source may have been met before: its column is emptied once it has been added
    for i in range(n):
        k = slider.source[i]
        if k == 2 * n or (i > 0 and k == slider.source[i - 1]):
            continue
        sign, j = (1.0, k) if k < n else (-1.0, k - n)
        s = turned(segment(path, j), sign)
        if slider.inside[k]:
            slopes = push_slopes(s, ratio)
            for a in range(P0):
                out.by[0, a] = slopes[a]
            for a in range(P0, P1 + 1):
                out.by[0, a] = sign * slopes[a]
            _add(slider.columns[k], -1.0, out.by[0], rows, j, out)
        else:
            by_p = sign * ratio * positive_slope(s[P1])
            for a in range(len(out.force)):
                slider.ends_u[j + 1, a] -= slider.columns[k, a]
                slider.ends_p[j + 1, a] += by_p * slider.columns[k, a]
        slider.columns[k] = 0.0
    add_products(slider.ends_u, rows.u, out.by_u)
    add_products(slider.ends_p, rows.p, out.by_p)


@inner
def _add(column: Floats, factor: float, by: Floats, rows: Rows, j: int, out: Scratch) -> None:
    """Adds factor column times the derivative of a quantity, from its derivatives by the numbers of segment j."""
    for b in range(len(out.force)):
        u = by[U0] * rows.u[j, b] + by[U1] * rows.u[j + 1, b]
        out.row_u[b] = u + by[DU0] * rows.du[j, b] + by[DU1] * rows.du[j + 1, b]
        out.row_p[b] = by[P0] * rows.p[j, b] + by[P1] * rows.p[j + 1, b]
    add_outer(column, factor, out.row_u, out.by_u)
    add_outer(column, factor, out.row_p, out.by_p)
