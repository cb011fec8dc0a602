"""Samples of a motion from its Fourier coefficients, inside compiled functions, and what they need."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]


class Tables(NamedTuple):
    """What links coefficients and samples. The first sample is repeated behind the last, so that segments have an end.

    synthesis: (n_coefficients, n_time) samples of each coefficient
    values, slopes: (n_time + 1, n_coefficients) derivative of a sample, and of its slope, by the coefficients
    shares: (n_time + 1, n_coefficients) what a sample adds to the coefficients
    constant: (n_coefficients,) coefficients of 1
    """

    synthesis: Floats
    values: Floats
    slopes: Floats
    shares: Floats
    constant: Floats


class GrowingTables(NamedTuple):
    """`Tables` for changes of the motion that grow as e^(s t), t = 0 at the first sample; the coefficients are those of
    the force's change times e^(-s t).

    last_period: e^(-s T), what a change one period earlier is times
    """

    values: NDArray[np.complex128]
    slopes: NDArray[np.complex128]
    shares: NDArray[np.complex128]
    last_period: complex


def growing(tables: Tables, growth: complex) -> GrowingTables:
    """growth: s / w"""
    n_time = len(tables.values) - 1
    step = 2 * np.pi * growth / n_time
    factor = np.exp(step * np.arange(n_time + 1))[:, None]
    # as `tables`, each sample by its own growth, which the factor of the middle one leaves in
    v = tables.values[:-1]
    near = np.roll(v, -1, axis=0) * np.exp(step) - np.roll(v, 1, axis=0) * np.exp(-step)
    far = np.roll(v, -2, axis=0) * np.exp(2 * step) - np.roll(v, 2, axis=0) * np.exp(-2 * step)
    slopes = (8 * near - far) / 12
    slopes = np.concatenate([slopes, slopes[:1]])
    values, slopes, shares = (
        np.ascontiguousarray(t, np.complex128)
        for t in (tables.values * factor, slopes * factor, tables.shares / factor)
    )
    return GrowingTables(values, slopes, shares, complex(np.exp(-2 * np.pi * growth)))


@lru_cache(maxsize=32)
def tables(harmonics: Harmonics, n_time: int) -> Tables:
    """raises: ValueError where n_time cannot resolve the highest harmonic"""
    synthesis, shares = harmonics.synthesis(n_time), np.ascontiguousarray(harmonics.analysis(n_time).T)
    near = np.roll(synthesis, -1, axis=0) - np.roll(synthesis, 1, axis=0)
    far = np.roll(synthesis, -2, axis=0) - np.roll(synthesis, 2, axis=0)
    constant = np.array([float(k == 0 and i == 0) for k in harmonics.orders for i in range(1 if k == 0 else 2)])
    values, slopes, shares = (np.concatenate([t, t[:1]]) for t in (synthesis, (8 * near - far) / 12, shares))
    return Tables(np.ascontiguousarray(synthesis.T), values, slopes, shares, constant)


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
    """(n_time + 1,) or (n_time + 1, n) -> same: derivative with respect to the number of the sample, fourth order."""
    n = len(values) - 1
    for t in range(n):
        near = values[(t + 1) % n] - values[(t - 1) % n]
        far = values[(t + 2) % n] - values[(t - 2) % n]
        out[t] = (8 * near - far) / 12
    out[n] = out[0]


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
