"""Which of Hill's exponents are those of the response, where contacts answer to all perturbations alike: of all copies
s + i k w, shifted by k harmonics and truncated, the ones whose modes are the most symmetric in their harmonics (Lazarus
and Thomas 2010; Guillot et al. 2020).
"""

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.stability.hill import HillProblem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


def symmetric_exponents(problem: HillProblem) -> Complex:
    """(2 m,) by falling real part [1/s]"""
    values, vectors = problem.eigen(problem.contact)
    mean = np.arange(-problem.order, problem.order + 1) @ _harmonic_shares(problem, vectors)
    kept = np.argsort(np.abs(mean), kind="stable")[: 2 * len(problem.structure)]
    return values[kept][np.argsort(-values[kept].real)]


def _harmonic_shares(problem: HillProblem, q: Complex) -> Floats:
    """(2 order + 1, n) share of each harmonic -order..order in modes (m c, n)."""
    order = problem.order
    parts = q.reshape(-1, problem.harmonics.n_coefficients, q.shape[-1])
    shares = np.zeros((2 * order + 1, q.shape[-1]))
    shares[order] = (np.abs(parts[:, 0]) ** 2).sum(axis=0)
    for k in range(1, order + 1):
        cosine, sine = parts[:, 2 * k - 1], parts[:, 2 * k]
        shares[order + k] = (np.abs(cosine - 1j * sine) ** 2).sum(axis=0) / 4
        shares[order - k] = (np.abs(cosine + 1j * sine) ** 2).sum(axis=0) / 4
    return shares / shares.sum(axis=0)
