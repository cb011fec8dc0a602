"""Samples of a motion from its Fourier coefficients, inside compiled functions, and what they need."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.keeping import inner, kept
from updamp.hbm.contact.compiled.shared import WHOLE_END, WHOLE_START
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]


class Tables(NamedTuple):
    """What links coefficients and samples. The first sample is repeated behind the last, so that segments have an end.

    synthesis: (n_coefficients, n_time) samples of each coefficient
    values, slopes: (n_time + 1, n_coefficients) derivative of a sample, and of its slope, by the coefficients
    hats: (n_time + 1, n_coefficients) the same of the integral of the motion between samples, a cubic each, against the
        hat about a sample (1 there, falling to 0 at its neighbours)
    shares: (n_time + 1, n_coefficients) what a sample adds to the coefficients
    weights: (n_time + 1, n_coefficients) what that integral adds to them, if all do: those of the cubics about the
        samples of a motion of these harmonics are exactly its own
    constant: (n_coefficients,) coefficients of 1
    """

    synthesis: Floats
    values: Floats
    slopes: Floats
    hats: Floats
    shares: Floats
    weights: Floats
    constant: Floats


class GrowingTables(NamedTuple):
    """`Tables` for changes of the motion that grow as e^(s t), t = 0 at the first sample; the coefficients are those of
    the force's change times e^(-s t).

    last_period: e^(-s T), what a change one period earlier is times
    """

    values: NDArray[np.complex128]
    slopes: NDArray[np.complex128]
    hats: NDArray[np.complex128]
    shares: NDArray[np.complex128]
    weights: NDArray[np.complex128]
    last_period: complex


def growing(tables: Tables, growth: complex) -> GrowingTables:
    """growth: s / w"""
    n_time = len(tables.values) - 1
    factor = np.exp(2 * np.pi * growth / n_time * np.arange(n_time + 1))[:, None]
    last_period = complex(np.exp(-2 * np.pi * growth))
    rows = _rows(np.ascontiguousarray(tables.values * factor, np.complex128), last_period)
    shares = np.ascontiguousarray(tables.shares / factor, np.complex128)
    return GrowingTables(*rows, shares, _weights(rows[2], shares), last_period)


@lru_cache(maxsize=32)
def tables(harmonics: Harmonics, n_time: int) -> Tables:
    """raises: ValueError where n_time cannot resolve the highest harmonic"""
    synthesis, shares = harmonics.synthesis(n_time), np.ascontiguousarray(harmonics.analysis(n_time).T)
    constant = np.array([float(k == 0 and i == 0) for k in harmonics.orders for i in range(1 if k == 0 else 2)])
    values, shares = (np.concatenate([t, t[:1]]) for t in (synthesis, shares))
    rows = _rows(values, 1.0)
    return Tables(np.ascontiguousarray(synthesis.T), *rows, shares, _weights(rows[2], shares), constant)


@lru_cache(maxsize=32)
def sampled(n_time: int) -> Floats:
    """(n_time + 1, n_time) what the integrals of a motion between samples against the hats add to its samples, if all
    do: those of the cubics about any samples give these back."""
    return np.ascontiguousarray(growing_sampled(n_time, 0.0).real)


def growing_sampled(n_time: int, growth: complex) -> NDArray[np.complex128]:
    """The same of changes of the motion that grow; growth: s / w"""
    last_period = complex(np.exp(-2 * np.pi * growth))
    growths = np.exp(2 * np.pi * growth / n_time * np.arange(n_time + 1))
    unit = np.concatenate([np.eye(n_time), np.eye(n_time)[:1]]) * growths[:, None]
    hats = _rows(np.ascontiguousarray(unit, np.complex128), last_period)[2]
    back = np.linalg.solve(hats[:-1].T, np.diag(growths[:-1]))  # from integrals to samples, transposed
    return np.ascontiguousarray(np.concatenate([back, last_period * back[:1]]))


def _rows(values: NDArray[Any], last_period: Any) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Of the samples, of their slopes, of the integrals against hats."""
    slopes, hats = np.empty_like(values), np.empty_like(values)
    slope_rows(values, last_period, slopes)
    hat_rows(values, slopes, last_period, hats)
    return values, slopes, hats


def _weights(hats: NDArray[Any], shares: NDArray[Any]) -> NDArray[Any]:
    """shares, so scaled that the integrals of a motion give its coefficients back."""
    back = np.linalg.inv(shares[:-1].T @ hats[:-1])
    return np.ascontiguousarray(shares @ back.T)


@inner
def sample(coefficients: Any, synthesis: Any, out: Any) -> None:
    """(n_coefficients,) -> (n_time + 1,)"""
    n_time = synthesis.shape[1]
    out[:] = 0.0
    for k in range(len(coefficients)):
        for t in range(n_time):
            out[t] += coefficients[k] * synthesis[k, t]
    out[n_time] = out[0]


@inner
def slope(values: Any, out: Any) -> None:
    """(n_time + 1,) -> same: derivative with respect to the number of the sample, fourth order."""
    n = len(values) - 1
    for t in range(2, n - 1):
        out[t] = (8 * (values[t + 1] - values[t - 1]) - (values[t + 2] - values[t - 2])) / 12
    for t in (0, 1, n - 1):
        far = values[(t + 2) % n] - values[(t - 2) % n]
        out[t] = (8 * (values[t + 1] - values[(t - 1) % n]) - far) / 12
    out[n] = out[0]


@kept
def slope_rows(values: Any, last_period: Any, out: Any) -> None:
    """As `slope`, (n_time + 1, n_coefficients) -> same; last_period: as in `GrowingTables`"""
    n = len(values) - 1
    for t in range(n + 1):
        for a in range(values.shape[1]):
            near = _row(values, t + 1, a, last_period) - _row(values, t - 1, a, last_period)
            far = _row(values, t + 2, a, last_period) - _row(values, t - 2, a, last_period)
            out[t, a] = (8 * near - far) / 12


@kept
def hat_rows(values: Any, slopes: Any, last_period: Any, out: Any) -> None:
    """Integrals of the cubics between samples against the hat about each; as `slope_rows`."""
    n = len(values) - 1
    for t in range(n + 1):
        for a in range(values.shape[1]):
            before, behind = _row(values, t - 1, a, last_period), _row(values, t + 1, a, last_period)
            rising, falling = _row(slopes, t - 1, a, last_period), _row(slopes, t + 1, a, last_period)
            of_values = (WHOLE_START[0] + WHOLE_END[1]) * values[t, a] + WHOLE_END[0] * before + WHOLE_START[1] * behind
            out[t, a] = of_values + WHOLE_END[2] * rising + WHOLE_START[3] * falling


@inner
def _row(values: Any, t: int, a: int, last_period: Any) -> Any:
    """Of any sample: those before the first and behind the last are of other periods."""
    n = len(values) - 1
    if t < 0:
        return values[t + n, a] * last_period
    if t > n:
        return values[t - n, a] / last_period
    return values[t, a]


@inner
def loop_area(motion: Any, force: Any) -> float:
    """Integral of force over motion, both (n_time + 1,), by the trapezoidal rule."""
    area = 0.0
    for t in range(len(motion) - 1):
        area += (force[t] + force[t + 1]) / 2 * (motion[t + 1] - motion[t])
    return area


@inner
def size_of_change(earlier: bool, last_period: Any) -> Any:
    """Of what moved a slider, as `GrowingTables` has it, in one kind of number; earlier: in the period before"""
    return last_period if earlier else 0.0 * last_period + 1.0


@inner
def add_outer(column: Any, factor: float, row: Any, out: Any) -> None:
    """out += factor column row^T"""
    for a in range(len(column)):
        scaled = factor * column[a]
        for b in range(len(row)):
            out[a, b] += scaled * row[b]


@inner
def add_products(columns: Any, rows: Any, out: Any) -> None:
    """out += columns^T rows, both (n, n_coefficients)"""
    out += np.dot(columns.T, rows)
