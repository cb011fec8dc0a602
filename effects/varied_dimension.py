"""What another value of a dimension changes of the model: data alone, made and used in `dimension_blend.py`."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class VariedDimension:
    """What a step of a dimension changes, in the modes of the model as built; m modes, n contacts.

    step: relative change of the dimension that the model was built once more with
    built: the components as built
    stiffening: (m, m) logarithm of the modal stiffness in units of that as built, diag(omega): relative, and 0 in
        directions of rigid motion; phi: (n_rows, m) difference of the modes
    root: (n_rows, n_rows) [(m/N)^1/2] factor B of the flexibility at rest B B', of all modes and what they leave;
        widening: difference of those that are nearest to each other; softening: logarithm of the ratio of their norms
    growth: entry of the contacts' parameters -> (n,) logarithm of its ratio, 0 where there is none
    shift: entry -> (n,) difference of what has no ratio
    weights: attachment -> point -> change of its weight
    """

    step: float
    built: LinearModel
    stiffening: Floats
    phi: Floats
    root: Floats
    widening: Floats
    softening: float
    growth: Mapping[str, Floats]
    shift: Mapping[str, Floats]
    weights: Mapping[str, Mapping[str, float]]

    def steps(self, change: float) -> float:
        """So many steps make the relative change, each by the same factor."""
        return float(np.log1p(change) / np.log1p(self.step))

    def softened(self, t: float) -> Floats:
        """(n_rows, n_rows) [m/N] what t steps change of the flexibility: its factor grows as its norm does."""
        share = np.expm1(t * self.softening) / np.expm1(self.softening) if self.softening else t
        there = self.root + share * self.widening
        return np.asarray(there @ there.T - self.root @ self.root.T)
