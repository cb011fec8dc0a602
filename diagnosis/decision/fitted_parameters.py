"""Values of an effect in a fit, with 95 % intervals."""

from updamp.diagnosis.candidate_models.intervals import intervals
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.verdict import FittedParameter
from updamp.effects.effect import Effect


def fitted_parameters(refit: Refit, effect: Effect) -> tuple[FittedParameter, ...]:
    """Of an effect in the fit, with 95 % intervals that hold those of all minima that are as likely, cut off at the
    bounds: what the data leave open, and how far the numerics may have moved it. By profile likelihood where that is
    known (`profiled.py`), else by derivatives where the fit ends."""
    found = []
    value, *others = (fitted.parametrisation.values(fitted.u)[effect.name] for fitted in (refit.fitted, *refit.also))
    each_fit = [_intervals(refit, effect), *(intervals(fitted, effect) for fitted in refit.also)]
    for i, q in enumerate(effect.parameters):
        lower = max(min(each[i][0] for each in each_fit), q.lower)
        upper = min(max(each[i][1] for each in each_fit), q.upper)
        also = tuple(other[q.name] for other in others)
        found.append(FittedParameter(q.name, q.unit, value[q.name], lower, upper, q.null, q.lower, q.upper, also))
    return tuple(found)


def _intervals(refit: Refit, effect: Effect) -> list[tuple[float, float]]:
    by_derivatives = intervals(refit.fitted, effect)
    names = [f"{effect.name}.{q.name}" for q in effect.parameters]
    return [refit.profiles.get(name, other) for name, other in zip(names, by_derivatives, strict=True)]
