"""A motion between two samples: the cubic through both values and slopes (Hermite), as scalars for numba.

A segment runs from 0 to 1. Its four numbers (v0, v1, d0, d1) are the values and the slopes a sample at its start and
end; derivatives by them come in this order. `hbm/contact/cubics.py` has the same for JAX.
"""

from typing import Any

from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.shared import AT_ROOT, MOST_STEPS


@inner
def positive(p: float) -> float:
    return p if p > 0 else 0.0


@inner
def powers(v0: float, v1: float, d0: float, d1: float) -> Any:
    """Coefficients of 1, t, t^2 and t^3."""
    return v0, d0, 3 * (v1 - v0) - 2 * d0 - d1, d0 + d1 - 2 * (v1 - v0)


@inner
def value(c: Any, t: float) -> float:
    return c[0] + t * (c[1] + t * (c[2] + t * c[3]))


@inner
def slope(c: Any, t: float) -> float:
    return c[1] + t * (2 * c[2] + 3 * t * c[3])


@inner
def less(one: Any, factor: float, other: Any) -> Any:
    """one - factor other"""
    return (
        one[0] - factor * other[0], one[1] - factor * other[1],
        one[2] - factor * other[2], one[3] - factor * other[3],
    )  # fmt: skip


@inner
def top(c: Any, a: float, b: float) -> float:
    """Where the slope falls through zero between a, where it is positive, and b, where it is negative."""
    slope_a, bend, third = slope(c, a), 2 * c[2] + 6 * c[3] * a, 3 * c[3]
    # the root of slope_a + bend x + third x^2 at which it falls, written so that nothing cancels where third is small
    x = 2 * slope_a / (-bend + max(bend * bend - 4 * third * slope_a, 0.0) ** 0.5)
    return min(max(a + x, a), b)


@inner
def rise_through(c: Any, level: float, sign: float, a: float, b: float) -> float:
    """Where sign times the cubic rises through sign times level between a, where it is not above, and b, where it is
    not below: by Newton's method within a bracket. Where it begins at the level, it depends on which way it goes."""
    low, high = a, b
    under = sign * (value(c, a) - level)
    if under >= 0 and sign * slope(c, a) >= 0:
        return a
    over = sign * (value(c, b) - level)
    t = a - under * (b - a) / (over - under) if under < 0 < over else (a + b) / 2
    for _ in range(MOST_STEPS):
        over, rate = sign * (value(c, t) - level), sign * slope(c, t)
        if over > 0:
            high = t
        else:
            low = t
        further = t - over / rate if rate > 0 else low
        if not low < further < high:
            further = (low + high) / 2
        moves, t = abs(further - t), further
        if moves < AT_ROOT:
            break
    return t


@inner
def halves(c: Any, a: float, b: float) -> Any:
    """Integrals of the cubic times 1 - t, and times t, from a to b."""
    total, moment, power_a, power_b = 0.0, 0.0, a, b
    for i in range(4):
        total += c[i] * (power_b - power_a) / (i + 1)
        power_a, power_b = power_a * a, power_b * b
        moment += c[i] * (power_b - power_a) / (i + 2)
    return total - moment, moment


@inner
def basis(t: float) -> Any:
    """Derivatives of the value at t by the four numbers."""
    rest = 1 - t
    return rest * rest * (1 + 2 * t), t * t * (3 - 2 * t), t * rest * rest, -t * t * rest


@inner
def basis_halves(a: float, b: float) -> Any:
    """Derivatives of both `halves` by the four numbers."""
    v0, v1 = halves((1.0, 0.0, -3.0, 2.0), a, b), halves((0.0, 0.0, 3.0, -2.0), a, b)
    d0, d1 = halves((0.0, 1.0, -2.0, 1.0), a, b), halves((0.0, 0.0, -1.0, 1.0), a, b)
    return (v0[0], v1[0], d0[0], d1[0]), (v0[1], v1[1], d0[1], d1[1])
