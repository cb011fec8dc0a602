"""Fit and numerical error that belong to each other: the error is asked for again where the fit ends."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.continuation import BranchStoppedError

Floats = NDArray[np.float64]
Found = TypeVar("Found")


@dataclass(frozen=True)
class OwnNumericsOptions:
    """again: how often at most what finer numerics change is asked for where a fit ends
    moved: in their stated deviations, what parameters may move by for what that has changed from where it was asked
        for, to first order, which the fit knows: beyond first order there is less
    given_up: whether a model that fails is given up where another fall as large would not explain the data. One of many
        that compete may be; the calibration that all of them rest on is not: far from where the error was asked for at
        first, the second fall may be the larger one
    """

    again: int = 4
    moved: float = 0.5
    given_up: bool = False


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
        before, _ = fit_of(found)
        if farthest_moved(before) <= options.moved:
            break
        try:
            last = again(found)
        except BranchStoppedError:  # of a finer model, far from where it was: what was found before stands
            break
        after, plan = fit_of(last)
        fall = before.compared.chi2 - after.compared.chi2
        if fall <= 0 and lack_of_fit(after, plan) < RISK:
            break
        found = last
        if options.given_up and lack_of_fit(after, plan, max(fall, 0.0)) < RISK:
            break
    return found


def farthest_moved(found: Fit) -> float:
    """The farthest of the model's parameters, in stated deviations: what they would be off by to first order if finer
    numerics changed no more at the fit's parameters than where that was asked for. Infinite where it was asked for
    without an effect that the model has, or measured points are compared with parts of a branch that it was not asked
    for."""
    c, numerics, n = found.compared, found.parametrisation.numerics, found.parametrisation.n_of_model
    if np.any(found.u[len(numerics.about) : n]):
        return np.inf
    of_repeats: dict[int, list[Floats]] = {a.repeat: [] for a in c.assemblies}
    for m in c.matched:
        change = _since_asked(c.branches[m.observations.test], m, numerics)
        if change is None:
            return np.inf
        of_repeats[m.observations.repeat].append(np.einsum("nrm,nm->nr", m.by_observation, change).ravel())
    changed = tuple(replace(a, residual=np.concatenate(of_repeats[a.repeat])) for a in c.assemblies)
    of_numerics, columns = replace(c, assemblies=changed).equations()
    off = found.covariance @ (columns.T @ of_numerics)
    return float(np.max(np.abs(off[:n]) / found.uncertainty[:n]))


def _since_asked(branch: PredictedBranch, matched: Matched, numerics: NumericalError) -> Floats | None:
    """(n, m) where the measured points are; None where that is not known of some of them, but for those at the ends of
    the branch itself"""
    condition, place = branch.condition, matched.place
    change, beyond = numerics.since_asked(condition.name, branch.at(place).value, condition.wider, branch.u)
    within = (place > branch.place[0]) & (place < branch.place[-1])
    return None if np.any(beyond & within) else change
