"""How far the error of the numerics may have moved the parameters of a finished fit."""

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.residual.fit import Fit

Floats = NDArray[np.float64]


def moved_by_numerics(fitted: Fit) -> Floats:
    """(p,) standard deviations of the model's parameters, effects among them, 0 for patterns of numerical error.

    What a finer model changes is known to within half of its size. A fit with that half as a pattern of its own tells
    it from the parameters by details of a thousand points, which are no surer than the pattern's shape; so here
    parameters make up for all of it as far as they can.
    """
    p, n = fitted.parametrisation, fitted.parametrisation.n_of_model
    _, columns = fitted.compared.equations()
    prior = np.diag(1 / p.deviation[:n])
    left = np.vstack([columns[:, :n], prior])
    found = np.zeros(len(p))
    for i, name in enumerate(p.names):
        if name.startswith("numerics.") and _is_whole(name):
            wanted = np.append(columns[:, i], np.zeros(n))
            moved = np.linalg.lstsq(left, wanted, rcond=None)[0]
            found[:n] = np.hypot(found[:n], moved)
    return found


def _is_whole(name: str) -> bool:
    """Patterns of one mode or one test have its name after a blank."""
    return " " not in name
