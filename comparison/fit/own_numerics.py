"""Fit and numerical error that belong to each other: the error is asked for again where the fit ends."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.observations import Plan
from updamp.hbm.continuation.continuation import BranchStoppedError

Found = TypeVar("Found")


@dataclass(frozen=True)
class OwnNumericsOptions:
    """again: how often at most what finer numerics change is asked for where a fit ends
    moved: in their stated deviations, what parameters move by from one time to the next where that is enough: numerical
        error and fit then belong to each other
    """

    again: int = 4
    moved: float = 0.5


def until_it_stays(
    found: Found,
    again: Callable[[Found], Found],
    fit_of: Callable[[Found], tuple[Fit, Plan]],
    options: OwnNumericsOptions = OwnNumericsOptions(),
) -> Found:
    """Until the parameters stay where the error was asked for, whatever that does to a misfit within the scatter: where
    a run of few points ends beside a jump, an error asked for elsewhere makes parameters up that the data seem to tell
    well. Of a model that fails, as long as it fails less.

    again: with the numerical error where it ends; fit_of: and the plan of the fit's runs
    """
    for _ in range(options.again):
        try:
            last = again(found)
        except BranchStoppedError:  # of a finer model, far from where it was: what was found before stands
            return found
        (before, _), (after, plan) = fit_of(found), fit_of(last)
        if _misfit(after) >= _misfit(before) and lack_of_fit(after, plan) < RISK:
            return found
        found = last
        if farthest_moved(before, after) <= options.moved:
            break
    return found


def farthest_moved(before: Fit, after: Fit) -> float:
    """The farthest of the model's parameters, in the smaller one of its two deviations."""
    n = after.parametrisation.n_of_model
    deviations = np.minimum(before.uncertainty[:n], after.uncertainty[:n])
    return float(np.max(np.abs(after.u[:n] - before.u[:n]) / deviations))


def _misfit(fit: Fit) -> float:
    return fit.compared.mean_squared_misfit
