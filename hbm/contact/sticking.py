"""Which friction elements surely neither slip nor separate, told from their motion without evaluating the law."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def stays_within(displacement: Floats, p: Any, size: Callable[[Floats, Floats], Floats], between: float) -> Bools:
    """(n_elements,) whether the force, marched from that at rest, never reaches the friction limit.

    displacement: (n_elements, 3, n_time) [m]; p: `friction.FrictionParameters` in NumPy arrays
    size: of the tangential force from its two components, to be held against the limit
    between: share of their largest values by which a force may exceed its samples between them (`between_samples`)
    """
    limit = (p.mu * p.kn)[:, None] * displacement[:, 2]
    limit += (p.mu * (p.n0 - p.kn * p.gap))[:, None]
    force = p.kt[:, None, None] * displacement[:, :2]
    force += p.t0[:, :, None]
    largest = size(force[:, 0], force[:, 1])
    reserve = between * (limit.max(axis=1) + largest.max(axis=1))
    return np.asarray((limit - largest).min(axis=1) > np.maximum(reserve, 0.0))


def between_samples(highest_order: int, n_time: int) -> float:
    """By how much a trigonometric polynomial of this order may exceed its samples, as a share of its largest value.

    Its second derivative is at most order^2 times its largest value (Bernstein), and a sample is never further than
    half a step away: (order step)^2 / 8. Twice that, as the laws interpolate by parabolas.
    """
    return (2 * np.pi * highest_order / n_time) ** 2 / 4


def larger_component(one: Floats, other: Floats) -> Floats:
    """For a box as the limit."""
    return np.asarray(np.maximum(np.abs(one), np.abs(other)))


def length(one: Floats, other: Floats) -> Floats:
    """For a circle as the limit."""
    return np.asarray(np.hypot(one, other))
