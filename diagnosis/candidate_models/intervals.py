"""95 % intervals of an effect's parameters in a fit, and whether they leave it open that there is no such effect."""

from collections.abc import Sequence

import numpy as np

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.moved_by_numerics import moved_by_numerics
from updamp.effects.effect import Effect

_95 = 1.96


def intervals(fitted: Fit, effect: Effect) -> list[tuple[float, float]]:
    """Of every parameter, not cut off at its bounds: what the data leave open, and how far the numerics may have moved
    it."""
    p, moved = fitted.parametrisation, moved_by_numerics(fitted)
    place, values = p.columns(effect.name).start, p.values(fitted.u)[effect.name]
    found = []
    for i, q in enumerate(effect.parameters):
        deviation = np.hypot(fitted.given_numerics[place + i], moved[place + i])
        half = _95 * float(deviation) * abs(q.typical - q.null)
        found.append((values[q.name] - half, values[q.name] + half))
    return found


def may_be_absent(fitted: Fit, effects: Sequence[Effect]) -> str:
    """Name of the first of these effects that the fit leaves open to be none: the intervals of all its parameters hold
    their null values, those that do nothing by themselves left out. "" without."""
    for effect in effects:
        nulls = zip(intervals(fitted, effect), effect.parameters, strict=True)
        if all(lower <= q.null <= upper for (lower, upper), q in nulls if not q.shape):
            return effect.name
    return ""
