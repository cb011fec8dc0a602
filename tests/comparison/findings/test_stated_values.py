"""Stated values are judged by what is stated of their own uncertainty."""

import math
from collections.abc import Mapping

import pytest

from updamp.comparison.findings.stated_values import RESONANCE, SHIFT, compare_features, feature_findings
from updamp.measurement.measurement import Feature

NAN = math.nan


def stated(
    quantity: str = RESONANCE, value: float = NAN, within: float = NAN, force: float = 17.0,
    lower: float = NAN, upper: float = NAN,
) -> Feature:  # fmt: skip
    return Feature(quantity, "OOP", force, value, lower, upper, within)


def told(model: Mapping[float, float], *features: Feature) -> list[tuple[str, float]]:
    compared = compare_features(features, lambda _, force: model[force])
    return [(finding.text, finding.significance) for finding in feature_findings(compared)]


def test_a_value_is_missed_by_its_own_uncertainty() -> None:
    at = {17.0: 442.5}
    assert told(at, stated(value=440.0, within=0.02)) == []
    assert told(at, stated(value=440.0, within=0.001)) == [
        ("OOP: resonance 0.57 % high at 17 N (442.5 Hz, stated 440 Hz within 0.1 %)", pytest.approx(5.68, rel=1e-2))
    ]


def test_a_shift_is_no_frequency() -> None:
    model = {0.1: 440.0, 17.0: 434.5}  # 1.25 % of shift
    below, shift = stated(value=440.0, within=0.01, force=0.1), stated(SHIFT, 0.010, 0.05)
    assert told(model, below, shift) == [
        ("OOP: shift of the resonance 25 % high at 17 N (0.0125, stated 0.01 within 5 %)", pytest.approx(5.0))
    ]


@pytest.mark.parametrize(("model", "sentence"), [
    (350.0, "OOP: resonance at 17 N is 350 Hz, below the stated 360 Hz"),
    (390.0, "OOP: resonance at 17 N is 390 Hz, above the stated 385 Hz"),
    (370.0, None),
])  # fmt: skip
def test_a_bound_is_missed_beyond_it(model: float, sentence: str | None) -> None:
    found = told({17.0: model}, stated(lower=360.0, upper=385.0))
    assert [text for text, _ in found] == ([sentence] if sentence else [])


def test_what_is_not_known_of_the_model_is_said_first_and_is_no_agreement() -> None:
    model = {3.0: 460.0, 17.0: NAN}
    texts = [
        text for text, _ in told(model, stated(value=440.0, within=0.01, force=3.0), stated(value=430.0, within=0.01))
    ]
    assert texts[0] == "OOP: resonance at 17 N is not known, since the model's curve is not complete"
    assert len(texts) == 2


def test_the_worst_by_its_own_uncertainty_comes_first() -> None:
    model = {3.0: 450.0, 17.0: 441.0}
    found = told(model, stated(value=440.0, within=0.005, force=3.0), stated(value=440.0, within=0.0004))
    assert [round(significance, 1) for _, significance in found] == [5.7, 4.5]
