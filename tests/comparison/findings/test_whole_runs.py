"""A run that reads another factor than the rest is named, and nothing that a structure does is taken for one."""

from dataclasses import replace

import numpy as np
import pytest
from support.held_beam import held_beam, of_beam
from support.two_modes import DRIVE, TIP, swept_levels, two_modes

from updamp.comparison.compare import compare
from updamp.comparison.comparison import Comparison
from updamp.measurement.measurement import MeasuredRun, Measurement

SOUND = held_beam((80.40,) * 3, (0.003,) * 3)


def scaled(run: MeasuredRun, factor: float) -> MeasuredRun:
    return replace(run, response=run.response * factor)


def with_factors(measurement: Measurement, *factors: float) -> Measurement:
    return replace(measurement, runs=tuple(scaled(r, f) for r, f in zip(measurement.runs, factors, strict=True)))


def test_a_run_that_reads_low_as_a_whole_is_named_and_nothing_else() -> None:
    """Excited where the mode moves 0.8 times as much: "the curves differ in shape", and no shape differs."""
    (found,) = of_beam(with_factors(SOUND, 1.0, 0.8, 1.0)).findings
    assert (found.quantity, found.level) == ("amplitude", SOUND.runs[1].level)
    assert found.relative == pytest.approx(1 / 0.8 - 1, rel=0.05)
    assert "the whole run reads 20 % low, at all frequencies, against the other runs of the mode" in found.text


def test_gains_that_differ_by_little_from_run_to_run_are_told() -> None:
    found = of_beam(with_factors(SOUND, 1.0, 1.02, 0.97)).findings
    assert {f.level: round(f.relative, 2) for f in found} == {SOUND.runs[1].level: -0.02, SOUND.runs[2].level: 0.03}


def test_two_levels_that_are_exchanged_are_both_named() -> None:
    found = of_beam(with_factors(SOUND, 1.0, 2.0, 0.5)).findings
    assert [(f.level, round(float(np.log2(1 + f.relative)), 1)) for f in sorted(found, key=lambda f: f.relative)] == [
        (SOUND.runs[1].level, -1.0),
        (SOUND.runs[2].level, 1.0),
    ]


@pytest.mark.parametrize("factor", [1.0, 1.3])
def test_what_all_runs_share_is_no_runs_own(factor: float) -> None:
    assert of_beam(with_factors(SOUND, factor, factor, factor)).findings == ()


@pytest.mark.parametrize(
    ("resonances", "losses"), [((80.40,) * 3, (0.003, 0.004, 0.006)), ((80.40, 80.36, 80.30), (0.003,) * 3)]
)
def test_damping_and_resonances_that_change_with_the_level_are_those(resonances, losses) -> None:
    found = of_beam(held_beam(resonances, losses)).findings
    assert found
    assert not any("whole run" in f.text for f in found)


def of_arm(*factors: tuple[float, float], repeats: int = 1, odd: int = 1) -> Comparison:
    return compare(two_modes(), swept_levels(*factors, repeats=repeats, odd=odd))[0]


def test_one_sensor_of_a_run_is_not_the_whole_run() -> None:
    (found,) = of_arm((1.0, 1.0), (1.0, 1.06), (1.0, 1.0)).findings
    assert (found.quantity, found.level, found.channel) == ("sensor", 2.0, TIP)
    assert found.relative == pytest.approx(1 / 1.06 - 1, abs=0.005)
    assert f"{TIP} reads 6.0 % high in the whole run" in found.text or f"{TIP} reads 5.9 % high" in found.text


def test_both_sensors_of_a_run_are() -> None:
    (found,) = of_arm((1.0, 1.0), (1.06, 1.06), (1.0, 1.0)).findings
    assert (found.quantity, found.level, found.channel) == ("amplitude", 2.0, "")
    assert found.relative == pytest.approx(1 / 1.06 - 1, abs=0.005)


def test_two_sensors_that_are_off_by_different_factors_have_a_sentence_each() -> None:
    found = of_arm((0.9, 1.1), (1.0, 1.0), (1.0, 1.0)).findings
    assert {f.channel: round(f.relative, 1) for f in found} == {DRIVE: 0.1, TIP: -0.1}
    assert {f.level for f in found} == {1.0}


def test_one_repeat_of_a_test_is_not_the_test() -> None:
    """ "The curves differ in shape", and none did."""
    (found,) = of_arm((1.0, 1.0), (1.06, 1.06), (1.0, 1.0), repeats=3, odd=2).findings
    assert (found.quantity, found.level) == ("amplitude", 2.0)
    assert "first at 2 N, repeat 2: the whole run reads" in found.text
    assert found.relative == pytest.approx(1 / 1.06 - 1, abs=0.01)


def test_one_sensor_of_one_repeat() -> None:
    (found,) = of_arm((1.0, 1.0), (1.0, 1.06), (1.0, 1.0), repeats=3, odd=3).findings
    assert (found.quantity, found.level, found.channel) == ("sensor", 2.0, TIP)
    assert f"first at 2 N, repeat 3: {TIP} reads" in found.text


@pytest.mark.parametrize("repeats", [1, 3])
def test_levels_that_scatter_by_a_third_of_a_per_cent_are_no_misfit(repeats: int) -> None:
    """As a force's control and a laser that is aligned anew repeat: "the curves differ in shape"."""
    measured = swept_levels((1.0, 1.0), (1.0, 1.0), (1.0, 1.0), repeats=repeats, odd=1)
    factors = np.exp(0.003 * np.random.default_rng(7).standard_normal(len(measured.runs)))
    found, *_ = compare(two_modes(), with_factors(measured, *factors))
    assert found.findings == ()
    assert found.adequate
