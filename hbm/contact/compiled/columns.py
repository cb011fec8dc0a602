"""What the samples of a motion, and their slopes, add to Fourier coefficients: gathered here, multiplied once."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.tables import add_outer, add_products


class Rows(NamedTuple):
    """Derivatives by the coefficients of the samples of a motion, of their slopes, and of its integral against each
    sample's hat, each (n_time + 1, n_coefficients), real or complex."""

    values: NDArray[Any]
    slopes: NDArray[Any]
    hats: NDArray[Any]


class Columns(NamedTuple):
    """What u or p of the slider's path add to the coefficients, to be multiplied by `Rows`: all (n_time + 1,
    n_coefficients); touched: (n_time + 1,) whether values and slopes have any"""

    values: NDArray[Any]
    slopes: NDArray[Any]
    hats: NDArray[Any]
    touched: NDArray[np.bool_]


@inner
def new_columns(weights: Any) -> Columns:
    one = np.zeros(weights.shape, weights.dtype)
    return Columns(one, one.copy(), one.copy(), np.zeros(len(one), dtype=np.bool_))


@inner
def add_numbers(by: Any, j: int, factor: float, weight: Any, columns: Columns) -> None:
    columns.touched[j] = columns.touched[j + 1] = True
    for a in range(len(weight)):
        scaled = factor * weight[a]
        columns.values[j, a] += by[0] * scaled
        columns.values[j + 1, a] += by[1] * scaled
        columns.slopes[j, a] += by[2] * scaled
        columns.slopes[j + 1, a] += by[3] * scaled


@inner
def empty(columns: Columns) -> None:
    columns.hats[:] = 0.0
    for t in range(len(columns.touched)):
        if columns.touched[t]:
            columns.values[t] = 0.0
            columns.slopes[t] = 0.0
            columns.touched[t] = False


@inner
def multiply(columns: Columns, rows: Rows, out: Any) -> None:
    add_products(columns.hats, rows.hats, out)
    for t in range(len(columns.touched)):
        if columns.touched[t]:
            add_outer(columns.values[t], 1.0, rows.values[t], out)
            add_outer(columns.slopes[t], 1.0, rows.slopes[t], out)
