"""A fit with the branches linear in the parameters about where they were solved.

Gauss-Newton with exact bounds: each step is a linear least squares problem within a box (P. B. Stark and R. L. Parker,
Computational Statistics 10 (1995) 129), cut back until the objective falls. An interior method, as scipy's
`least_squares` is, cannot leave a bound that it starts at, and an effect that is absent stands at one.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from updamp.comparison.fit.compared import Compared, compare_at, objective
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.parameters import Parametrisation

Floats = NDArray[np.float64]
# Steps at most, and the share of the objective by which a further one has to lower it.
_STEPS, _SETTLED = 16, 1e-4
# Shares of a step that are tried.
_SHARES = (1.0, 0.5, 0.25, 0.1, 0.03)
# Least room of a parameter that stands at its bound, which `lsq_linear` asks for.
_ROOM = 1e-12


def fit_within(parametrisation: Parametrisation, plan: Plan, about: Compared, lower: Floats, upper: Floats) -> Compared:
    """Parameters within the box and the offsets of each assembly, the scatter as it is.

    about: with the branches; lower, upper: (p,)
    """
    linear = _Linear(parametrisation, plan, about)
    here = linear.at(np.clip(about.u, lower, upper))
    for _ in range(_STEPS):
        now = objective(parametrisation, here)
        step, promised = linear.step(here, lower, upper)
        if promised < _SETTLED * here.weighed:
            break
        tried = (linear.at(np.clip(here.u + share * step, lower, upper)) for share in _SHARES)
        ahead = next((a for a in tried if objective(parametrisation, a) < now), None)
        if ahead is None:
            break
        here = ahead
        if now - objective(parametrisation, here) < _SETTLED * here.weighed:
            break
    return here


def within_bounds(parametrisation: Parametrisation, u: Floats, columns: Floats, wanted: Floats) -> Floats:
    """(n,) changes of the model's parameters from u that make up for a residual, as far as a fit may go.

    columns: (r, n); wanted: (r,)
    """
    n = parametrisation.n_of_model
    return _least_squares(columns, wanted, parametrisation.lower[:n] - u[:n], parametrisation.upper[:n] - u[:n])


def _least_squares(columns: Floats, wanted: Floats, lower: Floats, upper: Floats) -> Floats:
    """(p,) steps between bounds, of which 0 is no further out than round-off."""
    room = np.minimum(lower, -_ROOM), np.maximum(upper, _ROOM)
    return np.asarray(lsq_linear(columns, wanted, room, method="bvls").x)


class _Linear:
    def __init__(self, parametrisation: Parametrisation, plan: Plan, about: Compared) -> None:
        self._parametrisation, self._plan, self._about = parametrisation, plan, about

    def at(self, u: Floats) -> Compared:
        about = self._about
        return compare_at(self._parametrisation, u, self._plan, about.branches, about.scatter, about.offsets, None, 3)

    def step(self, here: Compared, lower: Floats, upper: Floats) -> tuple[Floats, float]:
        """(p,) of Gauss-Newton within the box, and what it promises to lower the objective by"""
        residual, columns = here.equations()
        deviation = self._parametrisation.deviation
        rows = np.vstack([columns, -np.diag(1 / deviation)])
        wanted = np.concatenate([residual, here.u / deviation])
        step = _least_squares(rows, wanted, lower - here.u, upper - here.u)
        return step, float(np.sum(wanted**2) - np.sum((wanted - rows @ step) ** 2))
