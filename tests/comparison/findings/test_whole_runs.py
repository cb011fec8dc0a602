"""A run that reads another factor than the rest is named, and nothing that a structure does is taken for one."""

from dataclasses import replace

import numpy as np
import pytest
from support.held_beam import held_beam, of_beam

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
