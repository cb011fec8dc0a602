"""A model that fails does not excuse itself, by drifts or otherwise."""

from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, measured

from updamp.comparison.fit.failing_model import STRETCHES, as_many, as_one, inflation, unlikelihood
from updamp.comparison.fit.fit_from_far import fit_from_far
from updamp.comparison.fit.fit_round import prior_scatter
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.effects.catalogue import JOINTS
from updamp.model.build import modal_before_effects
from updamp.model.calibration import OF_MODES
from updamp.model.rig_files import load_modal

MODEL = modal_before_effects(load_modal(Path(__file__).parents[3] / "rigs" / "brake_reuss.toml"))


@pytest.mark.parametrize("mean_square", [0.3, 1.0, 1.01, 4.0, 1e4])
def test_data_count_as_the_weights_of_a_fit_have_them(mean_square: float) -> None:
    n, step = 200, 1e-3
    chi2 = n * mean_square
    slope = (unlikelihood(chi2 + step, n, 10) - unlikelihood(chi2 - step, n, 10)) / (2 * step)
    assert slope == pytest.approx(1 / inflation(chi2, n, 10) ** 2, rel=0.06)  # the corner at 1 lies within a step of it


def test_the_mean_of_a_misfit_is_as_uncertain_as_the_inflated_noise_says() -> None:
    n, discrepancy, rng = 400, 1.5, np.random.default_rng(1)
    blocks = np.repeat(discrepancy * rng.standard_normal((4000, n // 10)), 10, axis=1)
    residual = blocks + rng.standard_normal((4000, n))
    expected = inflation(float(np.mean(np.sum(residual**2, axis=1))), n, 10) / np.sqrt(n)
    assert np.std(residual.mean(axis=1)) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("common", [0.0, 0.1, 0.5])
def test_values_that_have_an_error_in_common_count_for_less(common: float) -> None:
    m, n, rng = 10, 400, np.random.default_rng(2)
    blocks = np.repeat(rng.standard_normal((8000, n // m)), m, axis=1)
    residual = np.sqrt(common) * blocks + rng.standard_normal((8000, n))
    assert np.var(residual.mean(axis=1)) == pytest.approx(as_one(m, common) / n, rel=0.05)


def test_neighbours_count_as_one_at_least() -> None:
    assert as_one(10.0, float("inf")) == as_one(10.0, 2.0) == 10.0
    assert as_one(0.0, float("inf")) == as_one(0.7, 2.0) == 1.0


@pytest.mark.parametrize("points", [4, 15, 40, 400])
def test_what_a_model_lacks_counts_the_same_however_densely_a_curve_is_measured(points: int) -> None:
    assert points / as_many(points) == STRETCHES


def test_a_model_that_lacks_a_spring_does_not_call_it_drift() -> None:
    """A beam that hardens by several widths, and its linear model: runs stay within what is stated of their drift, and
    with the spring in the model they need none."""
    mode = Mode(80.38, 0.0031, 2.0)
    plan = plan_of(measured((mode,), Joint(cubic=1.3e10), (79.9, 81.6), (0.5, 1.0), True, 20, 0.01, 5))
    for effects, most in (((), 3.0), ((JOINTS["joint_cubic"],), 1.5)):
        p = Parametrisation(MODEL, OF_MODES, effects)
        found = fit_from_far(p, plan, np.zeros(len(p))).compared
        assert (found.mean_squared_misfit > 10) == (not effects)
        drifts = [b / prior_scatter(p, plan).drift for o in found.offsets.values() for b in o.drift.values()]
        assert np.abs(drifts).max() < most
