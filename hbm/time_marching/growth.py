"""How fast the change from period to period grows, told apart from drift and beating.

Near a periodic motion the state after n periods is s_n = s* + sum_k c_k mu_k^n, with Floquet's multipliers mu_k. The
changes d_n = s_(n+1) - s_n do not hold s*: a start that is only near the marched motion, as one with few harmonics is,
drifts to it and leaves decaying changes; a motion that does not attract leaves growing ones. The multipliers that act
come from a linear map fitted to the sequence (dynamic mode decomposition: Schmid 2010, J. Fluid Mech. 656, 5-28; here
in real arithmetic on its leading left singular vectors).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HELD_OUT = 3  # one of so many changes, the last ones, is not fitted but predicted
FEWEST = 6  # changes that a map is fitted to


class Growth(NamedTuple):
    """rate: of the change that grows fastest, or decays most slowly [1/s]; not a number where it cannot be told
    error: of the prediction of the changes that were not fitted, relative: 1 if it is worth nothing"""

    rate: float
    error: float


UNTOLD = Growth(np.nan, 1.0)


def growth(changes: Floats, period: float) -> Growth:
    """changes: (n, size) from one period to the next, in units in which all count alike; period [s]

    Of maps of all ranks the one is taken that predicts best what was not fitted, and is then fitted to all.
    """
    d = changes.T
    n = d.shape[1] - d.shape[1] // HELD_OUT
    if n < FEWEST or not d.any():
        return UNTOLD
    left, sizes, _ = np.linalg.svd(d[:, : n - 1], full_matrices=False)
    most = int((sizes > np.finfo(float).eps * max(d.shape) * sizes[0]).sum())
    errors = [_prediction_error(d, left[:, :r], n) for r in range(1, most + 1)]
    rank = 1 + int(np.argmin(errors))
    if errors[rank - 1] >= 1:
        return UNTOLD
    multipliers = np.linalg.eigvals(_map(d, np.linalg.svd(d[:, :-1], full_matrices=False)[0][:, :rank]))
    return Growth(float(np.log(np.abs(multipliers).max()) / period), float(errors[rank - 1]))


def _map(d: Floats, basis: Floats) -> Floats:
    """(r, r): takes each change, in the basis, to the next"""
    y = basis.T @ d
    return np.asarray(np.linalg.lstsq(y[:, :-1].T, y[:, 1:].T, rcond=None)[0].T)


def _prediction_error(d: Floats, basis: Floats, n: int) -> float:
    A, y, missed = _map(d[:, :n], basis), basis.T @ d[:, n - 1], 0.0
    for i in range(n, d.shape[1]):
        y = A @ y
        missed += float(np.sum((basis @ y - d[:, i]) ** 2))
    return float(np.sqrt(missed / np.sum(d[:, n:] ** 2)))
