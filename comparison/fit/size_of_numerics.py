"""How large numerical error is: by how much it moves resonances, and beside the sensors' noise."""

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared
from updamp.comparison.fit.imitated import beyond, imitated
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.parameters import Parametrisation

Floats = NDArray[np.float64]


def moved_frequencies(numerics: NumericalError, plan: Plan) -> str:
    """The most that all finer models together move a frequency by, such as "IP 0.35 %, OOP 0.3 %"; "" without any."""
    if numerics.expected is None:
        return ""
    most: dict[str, float] = {}
    for c in plan.conditions:
        most[c.mode] = max(most.get(c.mode, 0.0), float(np.abs(numerics.expected[c.name][:, 0]).max()))
    return ", ".join(f"{mode} {100 * share:.2g} %" for mode, share in most.items())


def beside_noise(parametrisation: Parametrisation, compared: Compared) -> float:
    """Variance of the numerical error, as unsure as it is and of what calibration cannot imitate, over that of the
    sensors' noise, the mean of all values."""
    p = parametrisation
    _, columns = compared.equations(of_sensors=True)
    n, deviation = len(p.nuisances), p.deviation[: len(p.nuisances)]
    patterns = np.vstack([columns[:, p.n_of_model :], np.zeros((n, len(p) - p.n_of_model))])
    left = beyond(imitated(columns[:, :n], deviation), patterns)
    return float(np.sum(left**2)) / compared.values
