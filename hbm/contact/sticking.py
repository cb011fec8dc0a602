"""Which friction elements surely neither slip nor separate, told from their motion without evaluating the law."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def within_box(displacement: Floats, parameters: Any, overshoot: float) -> Bools:
    """Of a law that holds each tangential force within the limit."""
    return stays_below_limit(displacement, parameters, _box_norm, overshoot)


def within_circle(displacement: Floats, parameters: Any, overshoot: float) -> Bools:
    """Likewise, of one that holds both together"""
    return stays_below_limit(displacement, parameters, np.hypot, overshoot)


def stays_below_limit(
    displacement: Floats, p: Any, norm: Callable[[Floats, Floats], Floats], overshoot: float
) -> Bools:
    """(n_elements,) whether the force, marched from that at rest, never reaches the friction limit.

    displacement: (n_elements, 3, n_time) [m]; p: `friction.FrictionParameters` in NumPy arrays
    norm: of the tangential force from its two components, compared with the limit
    overshoot: share of its largest value by which a force may exceed its samples between them
        (`overshoot_between_samples`)
    """
    limit = (p.mu * p.kn)[:, None] * displacement[:, 2]
    limit += (p.mu * (p.n0 - p.kn * p.gap))[:, None]
    force = p.kt[:, None, None] * displacement[:, :2]
    force += p.t0[:, :, None]
    size = norm(force[:, 0], force[:, 1])
    reserve = overshoot * (limit.max(axis=1) + size.max(axis=1))
    return np.asarray((limit - size).min(axis=1) > np.maximum(reserve, 0.0))


def overshoot_between_samples(highest_order: int, n_time: int) -> float:
    """By how much a trigonometric polynomial of this order may exceed its samples, as a share of its largest value.

    Its second derivative is at most order^2 times its largest value (Bernstein), and a sample is never further than
    half a step away: (order step)^2 / 8. Twice that, as the laws interpolate by parabolas.
    """
    return (2 * np.pi * highest_order / n_time) ** 2 / 4


def _box_norm(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.maximum(np.abs(one), np.abs(other)))
