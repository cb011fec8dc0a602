"""All methods: importing the files registers them. A new file joins with one line here."""

from updamp.design.methods import (
    full_grid,
    gaussian_process,
    latin_hypercube,
    least_squares,
    morris,
    nsga2,
    one_at_a_time,
    sobol,
    sobol_indices,
    tpe,
)
from updamp.design.methods.method import METHODS

__all__ = [
    "METHODS", "full_grid", "gaussian_process", "latin_hypercube", "least_squares", "morris", "nsga2", "one_at_a_time",
    "sobol", "sobol_indices", "tpe",
]  # fmt: skip
