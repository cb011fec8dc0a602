"""What a calibration can imitate, to first order and as far as the priors of its parameters let it."""

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def imitated(columns: Floats, deviation: Floats) -> Floats:
    """(n + p, k) orthonormal basis of what parameters can do to n whitened values and to their own priors, the latter
    as further rows, so that what a prior holds cannot imitate anything.

    columns: (n, p) derivatives; deviation: (p,) of the priors
    """
    return np.asarray(scipy.linalg.orth(np.vstack([columns, np.diag(1 / deviation)])))


def beyond(basis: Floats, rows: Floats) -> Floats:
    """What of (n + p,) or (n + p, m) rows no calibration can imitate."""
    return np.asarray(rows - basis @ (basis.T @ rows))
