"""Degrees of freedom of a fit whose parameters are partly known beforehand."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from updamp.comparison.fit.fit import Fit


def test_chi_square_of_an_adequate_model_is_as_large_as_its_freedom() -> None:
    """Parameters drawn as they are stated to be known, one of which nothing is known, noise of one deviation."""
    rng, n = np.random.default_rng(5), 60
    deviation = np.array([np.inf, 5.0, 1.0, 0.3, 0.02, *np.full(25, 0.01)])
    columns = rng.normal(size=(n, len(deviation)))
    covariance = np.linalg.inv(columns.T @ columns + np.diag(1 / deviation**2))
    stated: Any = SimpleNamespace(deviation=deviation)
    freedom = Fit(stated, SimpleNamespace(values=n), covariance, "").freedom  # type: ignore[arg-type]
    drawn = np.where(np.isfinite(deviation), deviation, 3.0)
    chi2 = []
    for _ in range(4000):
        data = columns @ (drawn * rng.normal(size=len(drawn))) + rng.normal(size=n)
        chi2.append(np.sum((data - columns @ (covariance @ columns.T @ data)) ** 2))
    assert abs(np.mean(chi2) / freedom - 1) < 0.01
    # a parameter that the data do not tell takes nothing off, one that they tell alone takes one
    assert n - 5 < freedom < n - 3
