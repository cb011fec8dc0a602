"""95 % intervals of an effect's parameters in a fit, and whether they leave it open that there is no such effect."""

from updamp.comparison.fit.fit import Fit
from updamp.effects.effect import Effect, EffectParameter

_95 = 1.96


def intervals(fitted: Fit, effect: Effect) -> list[tuple[float, float]]:
    """Of every parameter, not cut off at its bounds."""
    p, found = fitted.parametrisation, []
    values = p.values(fitted.u)[effect.name]
    for q, deviation in zip(effect.parameters, fitted.uncertainty[p.columns(effect.name)], strict=True):
        half = _95 * float(deviation) * abs(q.typical - q.null)
        found.append((values[q.name] - half, values[q.name] + half))
    return found


def in_units(parameter: EffectParameter, interval: tuple[float, float]) -> tuple[float, float]:
    """Of a parameter scaled as it is fitted, in its own unit; ascending"""
    lower, upper = sorted(parameter.null + u * (parameter.typical - parameter.null) for u in interval)
    return lower, upper


def may_be_absent(fitted: Fit) -> str:
    """Name of the first effect that the fit leaves open to be none: the intervals of all its parameters hold their null
    values, those that do nothing by themselves left out. "" without.

    Not asked of an effect that has no derivative at null: intervals are linear in its size, which says nothing of none
    of it. By how much chi-square falls with it does.
    """
    for effect in (e for e in fitted.parametrisation.effects if not e.finite_step):
        nulls = zip(intervals(fitted, effect), effect.parameters, strict=True)
        if all(lower <= q.null <= upper for (lower, upper), q in nulls if not q.shape):
            return effect.name
    return ""
