"""Where a test stands among the runs of an assembly, as measurement.toml numbers them."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.comparison.fit.observations import plan_of
from updamp.comparison.prediction.run_condition import same_sweeps
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement, MeasurementError


def run(name: str, level: float, upwards: bool, repeat: int, taken: int) -> MeasuredRun:
    frequency = np.linspace(79.0, 81.0, 12)
    response = 1e-6 / (1 - (frequency / 80) ** 2 + 0.01j) * (1 + 0.01 * np.sin(7 * np.arange(12)))
    return MeasuredRun(
        name, "B", upwards, "force", level, repeat, ("tip",), (1,), frequency, np.full(12, level + 0j),
        level * response[None, None], taken=taken,
    )  # fmt: skip


def conditions(*runs: MeasuredRun):
    return plan_of(Measurement("a test", 0.0, "tip.x", (Channel("tip", "tip.x"),), runs)).conditions


FIRST = (run("1 N", 1.0, True, 1, 3), run("2 N", 2.0, True, 1, 7))


def test_they_go_from_the_first_to_the_last_and_those_at_one_level_stand_together():
    """Up and down at 2 N, between others; the second assembly began with 1 N, the first ended with it."""
    found = conditions(
        run("2 N up", 2.0, True, 1, 11), run("2 N down", 2.0, False, 1, 12), run("1 N", 1.0, True, 1, 13),
        run("1 N", 1.0, True, 2, 1), run("2 N up", 2.0, True, 2, 2), run("2 N down", 2.0, False, 2, 4),
    )  # fmt: skip
    up, down, one = found
    assert up.place == down.place == pytest.approx(np.mean([-0.5, 0.0, 0.0, 0.5]))
    assert one.place == pytest.approx(0.0)
    assert same_sweeps(found) == [[0, 1], [2]]
    assert [c.place for c in conditions(*FIRST)] == [-0.5, 0.5]


def test_without_an_order_or_company_they_are_in_the_middle():
    assert [c.place for c in conditions(*(replace(r, taken=0) for r in FIRST))] == [0.0, 0.0]
    assert conditions(FIRST[0])[0].place == 0.0


def test_a_zero_has_no_logarithm_and_is_named():
    first = FIRST[0]
    response = first.response.copy()
    response[0, 0, 4] = 0
    with pytest.raises(MeasurementError, match=r"run '1 N' channel 'tip': response = 0 at 1 of 12"):
        conditions(replace(first, response=response))
