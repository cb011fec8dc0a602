"""Wording of the misfits of peaks: levels that agree together, the worst first, damping where it is told."""

from collections.abc import Callable

import numpy as np
import pytest

from updamp.comparison.findings.direction import Direction
from updamp.comparison.findings.kinds import Amplitude, Damping, Frequency, SensorGain
from updamp.comparison.findings.peak_misfit import PeakMisfit
from updamp.comparison.findings.peak_sentences import peak_findings
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.run_condition import RunCondition

TIPS = (("left.x", 1), ("right.x", 1))
NAMES = {"left.x": "tip_left", "right.x": "tip_right"}
LEVELS = {"IP": (2.0, 5.0, 8.0), "OOP": (4.0, 32.0)}
PLAN = Plan(
    tuple(
        RunCondition(f"{m} {f:g} N", m, f, True, (400.0, 410.0), TIPS) for m, levels in LEVELS.items() for f in levels
    ),
    (),
)
HALF_WIDTH = 0.002
UNIT = HALF_WIDTH * 3 * np.sqrt(3) / 2  # of a shift that is as bad as a height of 1


def left_tip(test: int) -> Direction:
    return SensorGain(test, sensor=TIPS[0])


def of(kind: Callable[[int], Direction], *relative: float, deviation: float = 0.01, first: int = 0) -> list[PeakMisfit]:
    """One a test, from the given one on."""
    unit = UNIT if kind is Frequency else 1.0
    return [
        PeakMisfit(kind(first + i), r, np.log1p(r) / deviation, abs(np.log1p(r)) / unit) for i, r in enumerate(relative)
    ]


def texts(*misfits: list[PeakMisfit]) -> list[str]:
    return [f.text for f in peak_findings([m for each in misfits for m in each], PLAN, NAMES)]


def test_levels_that_agree_become_one_sentence() -> None:
    (found,) = peak_findings(of(Amplitude, 0.20, 0.22, 0.24, 0.0, 0.001), PLAN, NAMES)
    assert found.text == "IP: peak 20 to 24 % high at every force level"
    assert (found.mode, found.level, found.quantity) == ("IP", None, Amplitude.quantity)
    assert found.relative == pytest.approx(0.22, abs=0.001)


def test_a_trend_is_said_as_one() -> None:
    (found,) = peak_findings(of(Frequency, 0.002, 0.0001, -0.004, deviation=1e-4), PLAN, NAMES)
    assert found.text == "IP: resonance 0.20 % high at 2 N, 0.40 % low at 8 N, right at 5 N"
    assert (found.level, found.relative) == (8.0, -0.004)


def test_what_all_runs_share_is_one_sentence_and_what_modes_do_not_is_two() -> None:
    assert texts(of(Amplitude, -0.15, -0.17, -0.2, -0.16, -0.18)) == ["peaks 15 to 20 % low in all runs"]
    assert (
        texts(of(left_tip, -0.21, -0.21, -0.21, 0.24, 0.24))
        == [
            "OOP: tip_left over tip_right 24 % high at every force level",
            "IP: tip_left over tip_right 21 % low at every force level",
        ][:: 1 if np.log(1.24) > -np.log(0.79) else -1]
    )


def test_what_amplitudes_are_wrong_by_most_comes_first() -> None:
    """0.15 % of frequency, three quarters of a half-width, is as bad as 29 % of height, 0.05 % as 10 %."""
    height = of(Amplitude, 0.2, 0.2, 0.2)
    said = "IP: peak 20 % high at every force level"
    for relative, place in ((0.0015, 0), (0.0005, 1)):
        both = texts(height, of(Frequency, relative, relative, deviation=1e-4, first=3))
        assert both[1 - place] == said
        assert both[place] == f"OOP: resonance {100 * relative:.2f} % high at every force level"


def test_nothing_is_said_within_the_scatter() -> None:
    """Ten statements held against it in two ways, to two sides: 3.48 deviations."""
    many = of(Amplitude, 0, 0, 0, 0, 0)
    assert texts(many, of(left_tip, 0.0340, 0, 0, 0, 0)) == []
    assert texts(many, of(left_tip, 0.0365, 0, 0, 0, 0)) == [
        "IP: tip_left over tip_right 3.6 % high at 2 N, right at 5 N, 8 N"
    ]


def test_damping_is_an_aside_where_the_phase_tells_it() -> None:
    height = of(Amplitude, 0.3, 0.3, 0.3)
    assert texts(height, of(Damping, -0.25, -0.22)) == [
        "IP: peak 30 % high at every force level (damping 22 to 25 % low at IP 2 N, IP 5 N)"
    ]
    assert texts(height, of(Damping, 0.01, 0.02, -0.02)) == ["IP: peak 30 % high at every force level (damping right)"]


def test_damping_has_a_sentence_of_its_own_where_that_of_the_heights_does_not_tell_it() -> None:
    """A clamp that gives way changes the modal mass: heights are right, by the loss factor, and damping is not."""
    heights = of(Amplitude, 0.01, 0.0, 0.005)
    assert texts(heights, of(Damping, -0.15, -0.17, -0.18)) == ["IP: damping 15 to 18 % low at every force level"]
    told_at = [m for m in of(Damping, -0.15, -0.17, -0.18) if m.direction.test != 1]
    assert texts(heights, told_at) == ["IP: damping 15 to 18 % low at 2 N, 8 N"]
    high = of(Amplitude, 0.3, 0.3, 0.3)
    assert texts(high, of(Damping, -0.03, -0.3, 0.2)) == [
        "IP: peak 30 % high at every force level",
        "IP: damping 30 % low at 5 N, 20 % high at 8 N, right at 2 N",
    ]


def test_a_level_that_is_not_told_is_not_called_right() -> None:
    unsure = [*of(Amplitude, 0.3, 0.001), *of(Amplitude, 0.1, deviation=0.2, first=2)]
    assert [f.text for f in peak_findings(unsure, PLAN, NAMES)] == ["IP: peak 30 % high at 2 N, right at 5 N"]
