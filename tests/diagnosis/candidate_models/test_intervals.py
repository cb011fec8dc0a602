"""Whether a fit leaves it open that an effect is absent; with made-up fits."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from updamp.diagnosis.candidate_models.intervals import intervals, may_be_absent
from updamp.effects.effect import Effect, EffectParameter


def parameter(name: str) -> EffectParameter:
    return EffectParameter(name, 0.0, -10.0, 10.0, 2.0, "N", "of a test")


SPRING = Effect("spring", "there is a spring", (parameter("stiffness"),), lambda model, _: model)
CRACK = Effect("crack", "there is a crack", (parameter("left"), parameter("right")), lambda model, _: model)
PLACES = {"spring": slice(0, 1), "crack": slice(1, 3)}


def fitted(values: list[float], deviations: list[float]) -> SimpleNamespace:
    """Of the spring and the crack, in N"""
    spring, *crack = values
    of = {"spring": {"stiffness": spring}, "crack": dict(zip(("left", "right"), crack, strict=True))}
    p = SimpleNamespace(effects=(SPRING, CRACK), columns=PLACES.get, values=lambda _: of)
    return SimpleNamespace(parametrisation=p, u=np.zeros(3), uncertainty=np.array(deviations) / 2.0)


def test_an_effect_is_there_whose_interval_ends_before_none_of_it():
    assert may_be_absent(fitted([2.0, 1.0, 1.0], [1.0, 0.1, 0.1])) == ""
    assert may_be_absent(fitted([2.0, 1.0, 1.0], [1.03, 0.1, 0.1])) == "spring"
    assert intervals(fitted([2.0, 0, 0], [1.0, 0, 0]), SPRING)[0] == pytest.approx((0.04, 3.96))


def test_of_several_parameters_one_that_is_known_not_to_be_null_is_enough():
    assert may_be_absent(fitted([9.0, 0.1, 5.0], [1.0, 1.0, 1.0])) == ""
    assert may_be_absent(fitted([9.0, 0.1, 1.0], [1.0, 1.0, 1.0])) == "crack"


def test_of_an_effect_without_a_derivative_at_null_an_interval_says_nothing_of_none_of_it():
    """Any share of the damper's mean motion above a millionth does nearly the same: 0.55 +- 0.6 of it took 13,000 off
    chi-square, and was not named (001 of the draw 94671990)."""
    found = fitted([2.0, 1.0, 1.0], [3.0, 0.1, 0.1])
    assert may_be_absent(found) == "spring"
    found.parametrisation.effects = (replace(SPRING, finite_step=True), CRACK)
    assert may_be_absent(found) == ""
