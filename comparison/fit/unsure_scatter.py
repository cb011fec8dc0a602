"""How much wider intervals are for the sizes of the scatter having been learnt from few repeats.

Three assemblies tell a standard deviation to a factor of two, so that twice the deviation of their mean is no 95 %
interval: that is W. S. Gosset's t in place of the normal distribution, with the degrees of freedom that each size is
known by (F. E. Satterthwaite, Biometrics Bull. 2 (1946) 110; for sizes learnt by restricted maximum likelihood F. G.
Giesbrecht and J. C. Burns, Biometrics 41 (1985) 477).
"""

from collections.abc import Sequence

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri, stdtrit

from updamp.comparison.fit.scatter import Assembly, Scatter, how_unsure

Floats = NDArray[np.float64]
_97_5 = 0.975


def widening(assemblies: Sequence[Assembly], scatter: Scatter, deviation: Floats) -> Floats:
    """(p, p) what is to be added to the covariance of the fitted parameters.

    scatter: as learnt from the assemblies, none of which is unsure where there is but one
    deviation: (p,) of the parameters before the fit
    """
    p = len(deviation)
    if len(assemblies) < 2:
        return np.zeros((p, p))
    kinds, by_offset, common, crossed = _of_offsets(assemblies, scatter)
    covariance = np.linalg.pinv(common + np.diag(1 / deviation**2), hermitian=True)
    names = list(dict.fromkeys(kinds))
    of_kind = np.array([[kind == name for kind in kinds] for name in names], dtype=np.float64)
    # what the likelihood says of the logarithm of each size, and what was known of it before
    projected = by_offset - crossed @ covariance @ crossed.T
    information = 2 * of_kind @ projected**2 @ of_kind.T
    prior = np.array([how_unsure(name) for name in names])
    # of each by itself, whatever the others are
    told = 1 / np.diag(np.linalg.inv(information + np.diag(prior**-2))) - prior**-2
    more = np.array([_wider(t / 2, p) ** 2 - 1 for t, p in zip(told, prior, strict=True)])
    moved_by = covariance @ crossed.T * np.sqrt(of_kind.T @ more)
    return np.asarray(moved_by @ moved_by.T)


def _wider(freedom: float, prior: float) -> float:
    """How many times as wide 95 % of an offset are as with a standard deviation that is known: by the repeats alone, or
    by what was known before alone, whichever tells it better. Both together would be narrower, and hold the truth less
    often where the assemblies differ by many times what was assumed.

    freedom: degrees of freedom of the repeats that tell it; prior: standard deviation of the logarithm before
    """
    by_repeats = stdtrit(freedom, _97_5) if freedom > 0 else np.inf
    at, weight = np.polynomial.hermite_e.hermegauss(40)

    def beyond(deviations: float) -> float:
        """Of a normal distribution of lognormal size"""
        return float(weight @ ndtr(deviations * np.exp(-prior * at)) / weight.sum() - _97_5)

    known = ndtri(_97_5)
    return float(min(by_repeats, brentq(beyond, known, 100 * known)) / known)


def _of_offsets(assemblies: Sequence[Assembly], scatter: Scatter) -> tuple[list[str], Floats, Floats, Floats]:
    """Kinds (q,) of all offsets, each divided by its deviation, and with R their columns, C the common ones and V the
    covariance of the residual: R^T V^-1 R (q, q), C^T V^-1 C (p, p), R^T V^-1 C (q, p)."""
    p = assemblies[0].common.shape[1]
    blocks, crossed, common = [], [], np.zeros((p, p))
    for a in assemblies:
        random = a.random * a.deviations(scatter)
        own, with_common = random.T @ random, random.T @ a.common / scatter.noise
        inner = scipy.linalg.cho_factor(np.eye(len(own)) + own)
        blocks.append(scipy.linalg.cho_solve(inner, own))
        crossed.append(scipy.linalg.cho_solve(inner, with_common))
        common = common + a.common.T @ a.common / scatter.noise**2 - with_common.T @ crossed[-1]
    kinds = [kind for a in assemblies for kind in a.kinds]
    return kinds, scipy.linalg.block_diag(*blocks), common, np.vstack(crossed)
