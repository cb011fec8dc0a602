"""One round of a fit: parameters, offsets and scatter with the branches linear about where they were solved."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared, compare_at, reweighed
from updamp.comparison.fit.linear_fit import fit_within
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import MOST_NOISE, Scatter, learn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]

# Change of a nuisance parameter up to which branches are nearly linear in it, however well it is known beforehand.
_LINEAR = 0.2
# Scatter of the parameters of a single assembly, as a share of what they are expected to scatter by.
_ALONE = 1e-3


def fit_linear(
    parametrisation: Parametrisation, plan: Plan, compared: Compared, scatter: Scatter, reach: float
) -> Compared:
    """Where a fit with a given scatter would go in one round: the branches linear in the parameters, which may change
    by `reach` of their scale."""
    prior = prior_scatter(parametrisation, plan)
    ahead = one_round(parametrisation, plan, compared, scatter, prior, reach)
    return reweighed(parametrisation, plan, ahead, scatter)


def prior_scatter(parametrisation: Parametrisation, plan: Plan) -> Scatter:
    """As stated, before repeats have been looked at. The only assembly is what the parameters are fitted to: its
    offsets from others cannot be separated from them."""
    share = 1.0 if len(plan.repeats) > 1 else _ALONE
    sizes = {n.name: share * n.scatter for n in parametrisation.nuisances}
    return Scatter(sizes, plan.drift, plan.gain, plan.level)


def compared_at_start(
    parametrisation: Parametrisation, u: Floats, plan: Plan, branches: Sequence[PredictedBranch], scatter: Scatter
) -> Compared:
    """Where nothing has been fitted yet: points are matched as far off as the priors have the parameters."""
    spread = np.where(np.isfinite(parametrisation.deviation), parametrisation.deviation, 0.0)
    return compare_at(parametrisation, u, plan, branches, scatter, None, spread)


def one_round(
    parametrisation: Parametrisation, plan: Plan, best: Compared, scatter: Scatter | None, prior: Scatter, reach: float
) -> Compared:
    """One round. Where the scatter is learnt, a misfit beyond what noise can be is none of it."""
    if scatter is not None:
        return _fit_linear(parametrisation, plan, best, scatter, prior, reach)
    most = reweighed(parametrisation, plan, best, replace(best.scatter, noise=MOST_NOISE * prior.noise))
    if (factor := most.inflation) == 1:
        return _fit_linear(parametrisation, plan, best, None, prior, reach)
    weighed = reweighed(parametrisation, plan, best, replace(best.scatter, noise=factor * prior.noise))
    return _fit_linear(parametrisation, plan, weighed, None, prior.inflated(factor), reach)


def _fit_linear(
    parametrisation: Parametrisation,
    plan: Plan,
    about: Compared,
    scatter: Scatter | None,
    prior: Scatter,
    reach: float,
) -> Compared:
    """Parameters, offsets and scatter with the branches linear about where they were solved."""
    lower, upper = step_limits(parametrisation, about.u, reach)
    if scatter is not None:
        return fit_within(parametrisation, plan, about, lower, upper)
    now, limits = about, _reach_of_each(parametrisation, about.u, reach)
    for _ in range(3):
        before, now = now, fit_within(parametrisation, plan, now, lower, upper)
        now = now.with_scatter(learn(now.assemblies, prior))
        if np.max(np.abs(now.u - before.u) / limits) < 0.01:
            break
    return now


def step_limits(parametrisation: Parametrisation, u: Floats, reach: float) -> tuple[Floats, Floats]:
    """(p,) each: how far down and up parameters may go from u to first order, within their bounds.

    reach: in units of the scale of each
    """
    limits = _reach_of_each(parametrisation, u, reach)
    return np.maximum(parametrisation.lower, u - limits), np.minimum(parametrisation.upper, u + limits)


def _reach_of_each(parametrisation: Parametrisation, u: Floats, reach: float) -> Floats:
    deviation = parametrisation.deviation
    # effects, of which nothing is known beforehand, may grow by as much as they are
    limits = reach * np.where(np.isfinite(deviation), np.maximum(deviation, _LINEAR), np.maximum(1.0, np.abs(u)))
    limits[parametrisation.n_of_model :] = 2 * parametrisation.upper[parametrisation.n_of_model :]  # exactly linear
    return np.asarray(limits)
