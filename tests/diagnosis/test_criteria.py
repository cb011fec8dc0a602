"""Limits of what is taken for chance."""

import numpy as np
import pytest

from updamp.diagnosis.criteria import Criteria, largest_by_chance


@pytest.mark.parametrize("independent", [24, 192])
@pytest.mark.parametrize("probability", [0.05, 0.0027])
def test_a_right_model_exceeds_the_limit_as_often_as_stated(independent: int, probability: float) -> None:
    misfits = np.mean(np.random.default_rng(6).normal(size=(40_000, independent)) ** 2, axis=1)
    share = np.mean(misfits > largest_by_chance(independent, probability))
    assert share == pytest.approx(probability, rel=0.25)


def test_few_values_tell_less() -> None:
    limits = [largest_by_chance(n, 0.0027) for n in (1, 10, 100, 1000)]
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] < 1.15


def test_three_deviations_of_a_calibration_are_as_unlikely() -> None:
    assert Criteria().calibration == pytest.approx(3.0, abs=1e-3)


def test_nothing_held_out_never_fails() -> None:
    assert not Criteria().fails(float("nan"), 0)
    assert not Criteria().is_doubtful(float("nan"), 0)
