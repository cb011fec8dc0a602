"""What a model leaves of the runs at the sensors, where it is matched across the branch (`matching.py`)."""

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.matching import Matched

Floats = NDArray[np.float64]


def columns_at_sensors(m: Matched) -> list[tuple[Floats, Floats]]:
    """Of each amplitude and phase that was recorded what is left (n,) and the share seen (n,), as below."""
    return list(zip(left_at_sensors(m).T, seen_at_sensors(m).T, strict=True))


def left_at_sensors(m: Matched) -> Floats:
    """(n, amplitudes and phases that were recorded) measured less model across the branch, in deviations of the
    sensors."""
    return np.asarray(np.einsum("nrm,nr->nm", to_sensors(m), m.residual))


def seen_at_sensors(m: Matched) -> Floats:
    """(n, amplitudes and phases that were recorded) variance that the sensors' noise leaves there, over their own: what
    lies along the branch is taken for a place further on."""
    known = [0, *recorded(m)]
    basis = m.by_observation[:, :, known] * m.noise[:, None, known]
    across = np.einsum("nrj,nrk->njk", basis, basis)
    of_sensors = (m.observations.noise[:, known] / m.noise[:, known]) ** 2
    return np.asarray((np.einsum("njk,nk->nj", across**2, of_sensors) / of_sensors)[:, 1:])


def to_sensors(m: Matched) -> Floats:
    """(n, values across the branch, amplitudes and phases that were recorded) what takes the former to the latter, in
    deviations of the sensors."""
    known = recorded(m)
    numerics = m.noise[:, known] / m.observations.noise[:, known]
    whitened = m.by_observation[:, :, known] * m.noise[:, None, known]
    return np.asarray(numerics[:, None, :] * whitened)


def recorded(m: Matched) -> NDArray[np.intp]:
    """Places of the amplitudes and phases that were recorded among the observations."""
    return 1 + np.flatnonzero(np.isfinite(m.noise[:, 1:]).all(axis=0))
