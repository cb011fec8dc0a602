"""Limits of what is taken for chance."""

import numpy as np
import pytest

from updamp.comparison.fit.failing_model import Freedom
from updamp.diagnosis.criteria import Criteria, largest_by_chance


@pytest.mark.parametrize("independent", [24, 192])
@pytest.mark.parametrize("probability", [0.05, 0.0027])
def test_a_right_model_exceeds_the_limit_as_often_as_stated(independent: int, probability: float) -> None:
    misfits = np.mean(np.random.default_rng(6).normal(size=(40_000, independent)) ** 2, axis=1)
    share = np.mean(misfits > largest_by_chance(Freedom(independent), probability))
    assert share == pytest.approx(probability, rel=0.25)


def test_a_right_model_fails_as_seldom_where_the_noise_is_read_off_the_runs() -> None:
    """Of 60 values and a noise known by 30 degrees of freedom one model in 20 would be said to fail at the limit for
    a noise that is stated, one in 370 at its own."""
    random = np.random.default_rng(7)
    misfits = np.mean(random.normal(size=(100_000, 60)) ** 2, axis=1) / (random.chisquare(30, size=100_000) / 30)
    assert np.mean(misfits > largest_by_chance(Freedom(60, noise=30), 0.0027)) == pytest.approx(0.0027, rel=0.25)
    assert np.mean(misfits > largest_by_chance(Freedom(60), 0.0027)) > 0.03


def test_few_values_tell_less() -> None:
    limits = [largest_by_chance(Freedom(n), 0.0027) for n in (1, 10, 100, 1000)]
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] < 1.15


def test_three_deviations_of_a_calibration_are_as_unlikely() -> None:
    assert Criteria().calibration(1) == pytest.approx(3.0, abs=1e-3)


def test_nothing_held_out_never_fails() -> None:
    assert not Criteria().fails(float("nan"), Freedom(0))
    assert not Criteria().is_doubtful(float("nan"), Freedom(0))
