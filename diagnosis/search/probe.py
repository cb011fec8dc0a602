"""Where a model fails badly, what each effect could do about it: to first order about a model that has it already.

About a calibrated model that lacks something large, first order tells little: calibration has led it astray, and
effects of the contacts are not linear that far (an uneven pressure acts with its square at first). So each effect is
put into the model as given at its typical size, with both signs where it has two, and the rest is linear from there.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.model.predicted_branch import PredictedBranch
from updamp.diagnosis.residual.fit import Fit, compare_at, fit_linear, misfit, predict
from updamp.diagnosis.residual.observations import Plan
from updamp.diagnosis.search.baseline import Baseline
from updamp.diagnosis.search.refit import as_given, coarse_enough
from updamp.hbm.continuation import BranchStoppedError

Floats = NDArray[np.float64]
# Of an effect's parameters from their typical size, and of nuisance parameters, in units of their scale.
_REACH = 2.0


@dataclass(frozen=True, eq=False)
class Probe:
    """start: (p,) of the effect's parameters in typical sizes, where the misfit is least to first order
    misfit: there (`fit.misfit`), on the runs that were looked at"""

    effect: Effect
    start: Floats
    misfit: float


def probes(
    start: Baseline, effects: Sequence[Effect], progress: Callable[[str], None] = lambda _: None
) -> tuple[Probe, ...]:
    """The best one of each effect, the least misfit first; effects with which the model has no response are left out.

    Looks at the highest level of each mode alone, where most is seen of what depends on the amplitude.
    """
    plan = start.train_plan.only(highest_levels(start.train_plan))
    at = as_given(start.fitted)
    near = predict(start.fitted.parametrisation, at, plan, options=coarse_enough(start.fitted))
    found = []
    for effect in effects:
        progress(f"{effect.name} at its typical size")
        tried = [_probe(start.fitted, plan, at, near, effect, sign) for sign in _signs(effect)]
        found += sorted((t for t in tried if t is not None), key=lambda t: t.misfit)[:1]
    return tuple(sorted(found, key=lambda p: p.misfit))


def highest_levels(plan: Plan) -> tuple[int, ...]:
    """Places of the conditions: the highest level of each mode."""
    highest: dict[str, int] = {}
    for i, condition in enumerate(plan.conditions):
        best = highest.get(condition.mode)
        if best is None or condition.level > plan.conditions[best].level:
            highest[condition.mode] = i
    return tuple(sorted(highest.values()))


def _signs(effect: Effect) -> Iterator[float]:
    yield 1.0
    if effect.has_two_signs:
        yield -1.0


def _probe(
    base: Fit, plan: Plan, at: Floats, near: Sequence[PredictedBranch], effect: Effect, sign: float
) -> Probe | None:
    extended: Parametrisation = replace(base.parametrisation, effects=(*base.parametrisation.effects, effect))
    scatter = base.compared.scatter
    u = base.parametrisation.with_further(at, np.full(len(effect.parameters), sign))
    u = np.clip(u, extended.lower, extended.upper)
    try:
        branches = predict(extended, u, plan, near, options=coarse_enough(base))
    except BranchStoppedError:
        return None
    compared = compare_at(extended, u, plan, branches, scatter)
    ahead = fit_linear(extended, plan, compared, scatter, _REACH)
    return Probe(effect, ahead.u[extended.columns(effect.name)], misfit(extended, ahead))
