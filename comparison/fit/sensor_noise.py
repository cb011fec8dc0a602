"""The sensors' noise, read off what a model leaves of the runs in place of the runs themselves.

How rough a run is tells its noise only where it has many points: third differences of a resonance in fifteen points are
as large as its noise, which is then taken for twice what it is, and what a model lacks goes unseen. A model that is
nearly right takes the resonance off. What it gets wrong is smooth, and third differences take that off in turn.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.roughness import deviation_of, third_differences

Floats = NDArray[np.float64]


def noise_of_sensors(matched: Sequence[Matched], plan: Plan) -> float:
    """Factor on the noise that the observations have: 1 where it is stated, and at most, since a model that fails may
    leave rougher runs than there were."""
    if not plan.noise_read:
        return 1.0
    rough = np.concatenate([third_differences(column) for m in matched for column in left_at_sensors(m).T])
    return min(1.0, deviation_of(rough)) if len(rough) else 1.0


def left_at_sensors(m: Matched) -> Floats:
    """(n, amplitudes and phases that were recorded) measured less model across the branch, in deviations of the
    sensors."""
    return np.asarray(np.einsum("nrm,nr->nm", to_sensors(m), m.residual))


def to_sensors(m: Matched) -> Floats:
    """(n, values across the branch, amplitudes and phases that were recorded) what takes the former to the latter, in
    deviations of the sensors."""
    recorded = 1 + np.flatnonzero(np.isfinite(m.noise[:, 1:]).all(axis=0))
    numerics = m.noise[:, recorded] / m.observations.noise[:, recorded]
    whitened = m.by_observation[:, :, recorded] * m.noise[:, None, recorded]
    return np.asarray(numerics[:, None, :] * whitened)
