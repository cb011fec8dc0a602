"""Values of an effect in a fit, with 95 % intervals."""

import numpy as np

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.moved_by_numerics import moved_by_numerics
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.verdict import FittedParameter
from updamp.effects.effect import Effect

_95 = 1.96


def fitted_parameters(refit: Refit, effect: Effect) -> tuple[FittedParameter, ...]:
    """Of an effect in the fit, with 95 % intervals that hold those of all minima that are as likely, cut off at the
    bounds: what the data leave open, and how far the numerics may have moved it."""
    p, found = refit.fitted.parametrisation, []
    value = p.values(refit.fitted.u)[effect.name]
    intervals = [_intervals(fitted, effect) for fitted in (refit.fitted, *refit.also)]
    for i, q in enumerate(effect.parameters):
        lower = max(min(each[i][0] for each in intervals), q.lower)
        upper = min(max(each[i][1] for each in intervals), q.upper)
        found.append(FittedParameter(q.name, q.unit, value[q.name], lower, upper, q.null, q.lower, q.upper))
    return tuple(found)


def _intervals(fitted: Fit, effect: Effect) -> list[tuple[float, float]]:
    """Of one minimum, for every parameter."""
    p, moved = fitted.parametrisation, moved_by_numerics(fitted)
    place, values = p.columns(effect.name).start, p.values(fitted.u)[effect.name]
    found = []
    for i, q in enumerate(effect.parameters):
        deviation = np.hypot(fitted.given_numerics[place + i], moved[place + i])
        half = _95 * float(deviation) * abs(q.typical - q.null)
        found.append((values[q.name] - half, values[q.name] + half))
    return found
