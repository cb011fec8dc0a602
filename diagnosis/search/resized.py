"""Once an effect explains the data: do other sizes of it explain them as well?

chi2 may have several minima along an effect's size, each as sharp as if it were the only one: contact stiffness, say,
takes up the rest. A fit finds one of them.
"""

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.residual.fit import Fit, FitOptions, compare_at, fit, objective, predict
from updamp.diagnosis.search.baseline import Baseline
from updamp.diagnosis.search.refit import as_given
from updamp.hbm.continuation import BranchStoppedError

Floats = NDArray[np.float64]

_ROUNDS = FitOptions(rounds=6)
# Of chi2, that 95 % of the minima of one parameter lie within.
_WITHIN = 3.84


def sizes(effects: tuple[Effect, ...]) -> tuple[float, ...]:
    """Times the size that was fitted, with the other sign too where there is one."""
    both = all(q.two_sided for effect in effects for q in effect.parameters)
    return (0.5, 2.0, -1.0) if both else (0.5, 2.0)


def resized(found: Fit, effects: tuple[Effect, ...], size: float, start: Baseline) -> Fit | None:
    """The fit from so many times the effects' sizes: the other parameters as they are, or as given, whatever is closer;
    None where the model has no response at either."""
    p, best = found.parametrisation, None
    for others in (found.u, as_given(found)):
        u = others.copy()
        for effect in effects:
            place = p.columns(effect.name)
            u[place] = size * found.u[place]
        u = np.clip(u, p.lower, p.upper)
        try:
            branches = predict(p, u, start.train_plan, found.compared.branches or None)
        except BranchStoppedError:
            continue
        compared = compare_at(p, u, start.train_plan, branches, found.compared.scatter)
        if best is None or objective(p, compared) < objective(p, best):
            best = compared
    if best is None:
        return None
    return fit(p, start.train_plan, best.u, found.compared.scatter, best.branches, _ROUNDS)


def as_likely(fitted: Fit, best: Fit) -> bool:
    """Whether the data do not tell one from the other; both of one parametrisation, the misfit that is left taken as
    noise"""
    further = objective(fitted.parametrisation, fitted.compared) - objective(best.parametrisation, best.compared)
    return further < _WITHIN * max(1.0, best.compared.excess)
