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
