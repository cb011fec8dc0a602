"""All methods: importing the files registers them. A new file joins with one line here."""

from updamp.design.methods import full_grid, latin_hypercube, one_at_a_time, sobol
from updamp.design.methods.method import METHODS

__all__ = ["METHODS", "full_grid", "latin_hypercube", "one_at_a_time", "sobol"]
