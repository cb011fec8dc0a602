"""By how much numerical error may have moved what a fit finds, and resonances, and how large it is beside noise."""

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.imitated import beyond, imitated
from updamp.comparison.fit.linear_fit import within_bounds
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.numerical_error import NumericalError

Floats = NDArray[np.float64]


def moved_frequencies(numerics: NumericalError, plan: Plan) -> str:
    """The most that all finer models together move a frequency by, such as "IP 0.35 %, OOP 0.3 %"; "" without any."""
    if numerics.expected is None:
        return ""
    most: dict[str, float] = {}
    for c in plan.conditions:
        most[c.mode] = max(most.get(c.mode, 0.0), float(np.abs(numerics.expected[c.name][:, 0]).max()))
    return ", ".join(f"{mode} {100 * share:.2g} %" for mode, share in most.items())


def beside_noise(fitted: Fit) -> float:
    """Variance of the numerical error, as unsure as it is and of what calibration cannot imitate, over that of the
    sensors' noise, the mean of all values."""
    p = fitted.parametrisation
    _, columns = fitted.compared.equations(of_sensors=True)
    n, deviation = len(p.nuisances), p.deviation[: len(p.nuisances)]
    patterns = np.vstack([columns[:, p.n_of_model :], np.zeros((n, len(p) - p.n_of_model))])
    left = beyond(imitated(columns[:, :n], deviation), patterns)
    return float(np.sum(left**2)) / fitted.compared.values


def moved_by_numerics(fitted: Fit) -> Floats:
    """(p,) standard deviations of the model's parameters, effects among them, 0 for patterns of numerical error.

    What a finer model changes is known to within half of its size. A fit with that half as a pattern of its own tells
    it from the parameters by details of a thousand points, which are no surer than the pattern's shape; so here
    parameters make up for all of it as far as they can and may.
    """
    p, n = fitted.parametrisation, fitted.parametrisation.n_of_model
    _, columns = fitted.compared.equations()
    prior = np.diag(1 / p.deviation[:n])
    left = np.vstack([columns[:, :n], prior])
    found = np.zeros(len(p))
    for i, name in enumerate(p.names):
        if name.startswith("numerics.") and _is_whole(name):
            wanted = np.append(columns[:, i], np.zeros(n))
            moved = within_bounds(p, fitted.u, left, wanted)
            found[:n] = np.hypot(found[:n], moved)
    return found


def _is_whole(name: str) -> bool:
    """Patterns of one mode or one test have its name after a blank."""
    return " " not in name
