"""Once an effect explains the data: do other sizes of it explain them as well?

chi2 may have several minima along an effect's size, each as sharp as if it were the only one: contact stiffness, say,
takes up the rest. A fit finds one of them.
"""

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared, objective
from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.fit.fit_round import fit_linear
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.refit import compared_at
from updamp.effects.effect import Effect

Floats = NDArray[np.float64]

# Times the size that was fitted.
SIZE_FACTORS = (0.5, 2.0)
_ROUNDS = FitOptions(rounds=6, retraced=False)
# Share of an effect's size by which it may change to first order: back from half of what was found.
_REACH = 1.0
# Of chi2, that 95 % of the minima of one parameter lie within.
_WITHIN = 3.84


def have_two_signs(effects: tuple[Effect, ...]) -> bool:
    return all(effect.has_two_signs for effect in effects)


def fit_from_size(found: Fit, effects: tuple[Effect, ...], size: float, start: Baseline) -> Fit | None:
    """The fit from so many times the effects' sizes: the other parameters as they are, or as given, whatever is closer;
    None where the model has no response at either, and where the fit comes back to what was found, which from most
    sizes first order tells: where a law takes long nothing else is to be solved then."""
    p, scatter, plan = found.parametrisation, found.compared.scatter, start.train_plan
    starts = [_sized(found, effects, size, others) for others in (found.u, p.before_calibration(found.u))]
    same, solved = partial(_same_minimum, found), list[Compared]()
    for compared in compared_at(p, plan, starts, found.compared):
        if same(fit_linear(p, plan, compared, scatter, _REACH)):
            return None
        solved.append(compared)
    best = min(solved, key=lambda compared: objective(p, compared), default=None)
    if best is None:
        return None
    other = fit(p, plan, best.u, scatter, best.branches, _ROUNDS, known=same)
    return None if same(other.compared) else other


def _same_minimum(found: Fit, other: Compared) -> bool:
    """Whether parameters lie within the region that holds 95 % of one of them about the minimum that was found."""
    apart = other.u - found.u
    return bool(apart @ np.linalg.pinv(found.covariance, hermitian=True) @ apart < _WITHIN)


def with_size(found: Fit, effects: tuple[Effect, ...], size: float) -> Fit:
    """Not fitted: effects of so many times their sizes in the model as given, without branches."""
    u = _sized(found, effects, size, found.parametrisation.before_calibration(found.u))
    return replace(found, compared=replace(found.compared, u=u, branches=()))


def _sized(found: Fit, effects: tuple[Effect, ...], size: float, others: Floats) -> Floats:
    p, u = found.parametrisation, others.copy()
    for effect in effects:
        place = p.columns(effect.name)
        u[place] = np.array(effect.of_size(size)) * found.u[place]
    return np.clip(u, p.lower, p.upper)


def as_likely(fitted: Fit, best: Fit) -> bool:
    """Whether the data do not tell one from the other; both of one parametrisation"""
    further = objective(fitted.parametrisation, fitted.compared) - objective(best.parametrisation, best.compared)
    return further < _WITHIN
