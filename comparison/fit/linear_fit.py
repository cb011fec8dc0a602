"""A fit with the branches linear in the parameters about where they were solved.

Gauss-Newton with exact bounds: each step is a linear least squares problem within a box (P. B. Stark and R. L. Parker,
Computational Statistics 10 (1995) 129), cut back until the objective falls. An interior method, as scipy's
`least_squares` is, cannot leave a bound that it starts at, and an effect that is absent stands at one.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from updamp.comparison.fit.compared import Compared, compare_at, objective
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.parameters import Parametrisation

Floats = NDArray[np.float64]
# Steps at most, and the share of the objective by which a further one has to lower it.
_STEPS, _SETTLED = 8, 1e-4
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
        lower_still = (a for a in linear.along_step(here, lower, upper) if objective(parametrisation, a) < now)
        ahead = next(lower_still, None)
        if ahead is None:
            break
        here = ahead
        if now - objective(parametrisation, here) < _SETTLED * here.weighed:
            break
    return here


class _Linear:
    def __init__(self, parametrisation: Parametrisation, plan: Plan, about: Compared) -> None:
        self._parametrisation, self._plan, self._about = parametrisation, plan, about

    def at(self, u: Floats) -> Compared:
        about = self._about
        return compare_at(self._parametrisation, u, self._plan, about.branches, about.scatter, about.offsets, None, 3)

    def along_step(self, here: Compared, lower: Floats, upper: Floats) -> Iterator[Compared]:
        """The comparison after shares of the step, the whole one first."""
        residual, columns = here.equations()
        deviation = self._parametrisation.deviation
        rows = np.vstack([columns, -np.diag(1 / deviation)])
        room = np.minimum(lower - here.u, -_ROOM), np.maximum(upper - here.u, _ROOM)
        step = lsq_linear(rows, np.concatenate([residual, here.u / deviation]), room, method="bvls").x
        for share in _SHARES:
            yield self.at(np.clip(here.u + share * step, lower, upper))
