"""When a sentence counts as right, on comparisons made up for the purpose."""

from dataclasses import replace

import numpy as np
import pytest
from support.synthetic_comparison import features_only

from updamp.benchmarks.hidden_effects.sentence_rule import FREQUENCY, HEIGHT, SIDES, in_words, judged
from updamp.benchmarks.hidden_effects.sentences import table
from updamp.comparison.comparison import Comparison, CurvePair, Finding, MeasuredCurve, ModelCurve

LEVELS = {"IP 2 N": 2.0, "IP 8 N": 8.0}


def receptance(frequency: np.ndarray, at: float, height: float) -> np.ndarray:
    return height * 0.005j / (1 - (frequency / at) ** 2 + 0.005j)


def pair(run: str, channel: str, at: float, height: float) -> CurvePair:
    """Measured: 420 Hz, height 1; the model as given."""
    f, fine = np.linspace(415, 425, 41), np.linspace(410, 430, 800)
    measured = tuple(MeasuredCurve(k, f, receptance(f, 420.0, 1.0), np.ones(41)) for k in (1, 2))
    model = ModelCurve(fine, receptance(fine, at, height), np.ones(800, dtype=bool))
    return CurvePair(run, "IP", LEVELS[run], False, channel, measured, np.zeros((0, 3)), model, model, 1, 1, 1)


def comparison(*said: Finding, at: float = 420.0, left: float = 1.0, right: float = 1.0) -> Comparison:
    """The model is as given at 8 N, right at 2 N."""
    curves = (
        pair("IP 2 N", "tip_left", 420.0, 1.0),
        pair("IP 2 N", "tip_right", 420.0, 1.0),
        pair("IP 8 N", "tip_left", at, left),
        pair("IP 8 N", "tip_right", at, right),
    )
    return replace(features_only(), findings=said, adequate=not said, curves=curves)


def finding(quantity: str, relative: float, level: float | None = 8.0) -> Finding:
    return Finding("...", "IP", level, quantity, "", relative, 5.0)


def changes(**at_8_newton: float) -> dict[str, dict[str, float]]:
    none = {FREQUENCY: 0.0, HEIGHT: 0.0, SIDES: 0.0}
    return {"IP 2 N": none, "IP 8 N": none | {k.replace("_", " "): v for k, v in at_8_newton.items()}}


HIGH = comparison(finding("amplitude", 0.2), left=1.2, right=1.2)


@pytest.mark.parametrize(
    ("compared", "does", "mark"),
    [
        (HIGH, changes(peak=-0.2), "yes"),
        (HIGH, changes(peak=0.2), "no"),
        (HIGH, changes(peak=-0.005), "no"),
        (HIGH, changes(resonance=0.01), "no"),
        # at 2 N the model is right: what is said of every level is not what the curves show
        (replace(HIGH, findings=(finding("amplitude", 0.2, None),)), changes(peak=-0.2), "no"),
        (replace(HIGH, findings=(finding("amplitude", -0.2),)), changes(peak=0.2), "no"),
        (replace(HIGH, findings=(finding("amplitude", 0.6),)), changes(peak=-0.2), "no"),
        (comparison(finding("frequency", 0.002), at=420.84), changes(resonance=-0.002), "yes"),
        (comparison(finding("frequency", 0.002), at=420.84), changes(resonance=0.002), "no"),
        (comparison(finding("sensor", 0.2), left=1.1, right=0.9), changes(left_over_right=-0.3), "yes"),
        (comparison(finding("sensor", 0.2), left=1.1, right=0.9), changes(peak=-0.3), "no"),
        (comparison(), changes(peak=-0.2), "missed"),
        (comparison(), {}, "yes"),
        (HIGH, {}, "no"),
    ],
)
def test_marks(compared: Comparison, does: dict[str, dict[str, float]], mark: str) -> None:
    assert judged(compared, does).mark == mark


def test_what_calibration_takes_up_is_taken_off() -> None:
    """All peaks are lowered, least at 8 N: a larger loss factor leaves the model low there."""
    low = comparison(finding("amplitude", -0.1), left=0.9, right=0.9)
    heights = dict(zip(LEVELS, (-0.4, -0.2), strict=True))
    lowered = {test: {FREQUENCY: 0.0, HEIGHT: height, SIDES: 0.0} for test, height in heights.items()}
    found = judged(low, lowered)
    assert (found.mark, found.main) == ("yes, calibrated", True)
    # of what changes most is another matter
    assert judged(low, {t: v | {FREQUENCY: 0.001} for t, v in lowered.items()}).main
    assert not judged(low, {t: v | {FREQUENCY: 0.1 * v[HEIGHT]} for t, v in lowered.items()}).main


def test_words_and_table() -> None:
    assert in_words(changes(peak=-0.2, resonance=0.002)) == "IP resonance +0.00, +0.20 %; IP peak +0, -18 %"
    row = {"case": "case_017", "hidden": "a strong", "does": "d", "excess": 3.0, "sentences": ["one", "two"],
           "mark": "yes", "why": "", "main": False}  # fmt: skip
    text = table([row, row | {"hidden": "nothing", "sentences": ["no misfit"], "main": False}])
    assert "| 017 | a strong | d | 3 | **one**; two | yes; not of what changes most |" in text
    assert "1 of 1 right" in text
    assert "nothing said in 1 of 1" in text
