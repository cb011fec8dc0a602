"""Whether a prediction's error is more than it is uncertain by."""

import numpy as np
import pytest

from updamp.comparison.fit.prediction_error import uncertain_misfit


def test_it_is_that_of_the_dense_covariance() -> None:
    rng = np.random.default_rng(4)
    residual, columns, root = rng.normal(size=30), rng.normal(size=(30, 5)), rng.normal(size=(5, 3))
    covariance = root @ root.T  # of rank three: a parameter that is known exactly has no part in it
    dense = residual @ np.linalg.solve(np.eye(30) + columns @ covariance @ columns.T, residual) / 30
    assert uncertain_misfit(residual, columns, covariance) == pytest.approx(dense, rel=1e-10)


def test_a_model_that_lacks_nothing_is_off_by_what_its_prediction_is_uncertain_by() -> None:
    """Straight lines fitted to a few noisy values, and predicted far outside."""
    rng, found, plain = np.random.default_rng(5), [], []
    seen, unseen = (np.column_stack([np.ones(n), np.linspace(*ends, n)]) for n, ends in ((8, (0, 1)), (40, (2, 3))))
    for _ in range(400):
        truth = rng.normal(size=2)
        fitted, *_ = np.linalg.lstsq(seen, seen @ truth + rng.normal(size=8), rcond=None)
        residual = unseen @ truth + rng.normal(size=40) - unseen @ fitted
        found.append(uncertain_misfit(residual, unseen, np.linalg.inv(seen.T @ seen)))
        plain.append(residual @ residual / 40)
    assert np.mean(found) == pytest.approx(1.0, abs=0.04)
    assert np.mean(plain) > 4  # as if parameters were known
