"""Whether a prediction's error is more than it is uncertain by."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, measured

from updamp.comparison.fit.fit_from_far import fit_from_far
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.fit.prediction_error import prediction_error, uncertain_misfit
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.model.build import modal_before_effects
from updamp.model.calibration import OF_MODES
from updamp.model.rig_files import load_modal


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


@pytest.mark.parametrize("times", [1.0, 1.3])
def test_what_a_run_that_no_fit_saw_would_have_to_be_off_by_is_named(times: float) -> None:
    """A sensor's gain of 1 %, a level of 0.1 %: thirty per cent are of the sensor."""
    model = modal_before_effects(load_modal(Path(__file__).parents[3] / "rigs" / "brake_reuss.toml"))
    test = measured((Mode(80.38, 0.0031, 2.0),), Joint(), (79.9, 80.9), (0.1, 0.4), True, 41, 3e-3, 3)
    plan = plan_of(test)
    fitted = fit_from_far(Parametrisation(model, OF_MODES), plan, np.zeros(len(OF_MODES)))
    off = plan_of(replace(test, runs=tuple(replace(run, response=times * run.response) for run in test.runs)))
    found = prediction_error(fitted, off)
    if times == 1:
        assert abs(found.deviations) < 3
    else:
        assert found.farthest == "the gain of the sensor at beam.drive.x"
        assert found.deviations == pytest.approx(np.log(times) / fitted.compared.scatter.gain, rel=0.1)
