"""How far a fit is off runs that it has not seen, and whether that is more than the prediction is uncertain by.

A prediction has the scatter of a run, and what the fit leaves open: parameters, and the numerical error of a level
that no fit has seen. With covariance P of the fit's parameters and columns C of a whitened residual r by them, the
covariance of r is 1 + C P C^T (posterior predictive distribution: A. Gelman and others, Bayesian Data Analysis, 3rd ed.
(2013), section 14.3). All of it is that of a model which lacks nothing: P is what the sensors' noise leaves open, and
a fit that fails is not granted more.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared, compare_at, predict_branches
from updamp.comparison.fit.fit import Fit, covariance_of
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.offsets import split
from updamp.comparison.fit.scatter import offsets_of
from updamp.comparison.prediction.branch_tasks import Branches, in_turn

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PredictionError:
    """error: weighted residual RMS in deviations of the scatter alone; misfit: mean squared misfit in units of what
    the prediction is uncertain by too; nan where there are no runs; values: that were compared
    farthest: which drift, level or gain of these runs would have to be farthest off if nothing else were; deviations:
        by how many of its own"""

    error: float = float("nan")
    misfit: float = float("nan")
    values: int = 0
    farthest: str = ""
    deviations: float = 0.0


def prediction_error(fitted: Fit, plan: Plan, branches_of: Branches = in_turn) -> PredictionError:
    """On the plan's runs, parameters and scatter as they were fitted.

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    if not plan.conditions:
        return PredictionError()
    branches = predict_branches(fitted.parametrisation, fitted.u, plan, None, branches_of)
    compared = compare_at(fitted.parametrisation, fitted.u, plan, branches, fitted.compared.scatter)
    farthest, deviations = _farthest(compared, plan)
    return replace(of_compared(compared, fitted), farthest=farthest, deviations=deviations)


def _farthest(compared: Compared, plan: Plan) -> tuple[str, float]:
    """With all of the misfit put down to offsets, however many deviations of theirs that takes."""
    found: list[tuple[str, float]] = []
    for a in compared.assemblies:
        runs = [o for o in plan.observations if o.repeat == a.repeat]
        offsets, _ = offsets_of(a, compared.scatter)
        found += split(offsets, runs, [plan.conditions[o.test] for o in runs]).in_deviations(compared.scatter)
    return max(found, key=lambda named: abs(named[1]))


def of_compared(compared: Compared, fitted: Fit) -> PredictionError:
    """compared: the fit on runs that it has not seen"""
    error = float(np.sqrt(compared.mean_squared_misfit))
    covariance = covariance_of(fitted.parametrisation, fitted.compared, of_sensors=True)
    misfit = uncertain_misfit(*compared.equations(of_sensors=True), covariance)
    return PredictionError(error, misfit, compared.values)


def uncertain_misfit(residual: Floats, columns: Floats, covariance: Floats) -> float:
    """Mean of r^T (1 + C P C^T)^-1 r over the values.

    residual: (n,) r, whitened; columns: (n, p) C; covariance: (p, p) P, positive semidefinite
    """
    sizes, directions = np.linalg.eigh(covariance)
    spread = columns @ (directions * np.sqrt(np.maximum(sizes, 0.0)))
    seen = spread.T @ residual
    explained = seen @ np.linalg.solve(np.eye(len(seen)) + spread.T @ spread, seen)
    return float((residual @ residual - explained) / len(residual))
