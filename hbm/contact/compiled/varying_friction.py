"""A compiled law whose friction coefficient depends on the velocity."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import CompiledFriction, of_each

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class VaryingFriction:
    """inner: the law with any friction over the period
    friction: from velocities (n, 2, n_time) [m/s] and parameters: mu (n, n_time), and its derivative by the velocities
        (n, 2, n_time) [s/m]
    rates: (n_coefficients, n_time) samples of the velocity of each coefficient, over w
    """

    inner: CompiledFriction
    friction: Callable[[Floats, Any], tuple[Floats, Floats]]
    rates: Floats

    def write_forces(
        self, numbers: Integers, displacement: Floats, w: float | Floats, parameters: Any, force: Floats
    ) -> None:
        mu, _ = self.friction(_of_all(w) * (displacement[:, :2] @ self.rates), parameters)
        self.inner.write_forces(numbers, displacement, w, parameters._replace(mu=mu), force)

    def write_with_tangents(
        self,
        numbers: Integers,
        displacement: Floats,
        w: float | Floats,
        parameters: Any,
        force: Floats,
        tangent: Floats,
        by_frequency: Floats,
    ) -> None:
        speed = displacement[:, :2] @ self.rates
        mu, slope = self.friction(_of_all(w) * speed, parameters)
        p, slope = parameters._replace(mu=mu), slope[numbers]
        self.inner.write_with_tangents(numbers, displacement, w, p, force, tangent, by_frequency)
        by_motion = of_each(w, numbers)[..., None, None] * slope[..., None] * self.rates.T
        by_w = np.sum(slope * speed[numbers], axis=1)[..., None]
        found = self.inner.by_friction(numbers, displacement, p, np.concatenate([*by_motion.swapaxes(0, 1), by_w], 2))
        for d in range(2):
            of_direction = found[..., d * len(self.rates) : (d + 1) * len(self.rates)]
            tangent[numbers, :2, :, d] += of_direction
        by_frequency[numbers, :2], by_frequency[numbers, 2] = found[..., -1], 0.0


def _of_all(w: float | Floats) -> Floats:
    """(n_elements or 1, 1, 1)"""
    return np.asarray(w, dtype=float).reshape(-1, 1, 1)
