"""Kinds of misfit: what each takes from a run, and that a new one is a class and its place among the others."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from updamp.comparison.findings import findings
from updamp.comparison.findings.direction import Direction, Misfit
from updamp.comparison.findings.kinds import KINDS, OF_MODES, Amplitude, Damping, Frequency, OfSensors, SensorGain
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.model.calibration import LOSS_FACTOR

SENSORS = (("a.x", 1), ("b.x", 1), ("a.x", 3))
PARAMETERS = ("modal_mass", LOSS_FACTOR.name)
POINTS, SEEN = 7, 1 + 2 * len(SENSORS)
PLAN = Plan(tuple(RunCondition(f"first {f:g} N", "first", f, True, (40.0, 44.0), SENSORS) for f in (1.0, 4.0)), ())


@pytest.fixture
def run() -> Matched:
    """Of the second test, with numbers that are all different."""
    rng = np.random.default_rng(0)
    none = np.zeros((POINTS, SEEN))
    return Matched(
        Observations("run", 1, 1, none, none, np.zeros(POINTS)), np.zeros(POINTS), none, none,
        rng.normal(size=(POINTS, SEEN - 1)), rng.normal(size=(POINTS, SEEN - 1, len(PARAMETERS))),
        rng.normal(size=(POINTS, SEEN - 1, SEEN)),
    )  # fmt: skip


def column(direction: Direction, run: Matched) -> np.ndarray:
    return direction.column(run, SENSORS, PARAMETERS)


def test_each_takes_its_own_from_a_run(run: Matched) -> None:
    gains = [column(SensorGain(sensor=sensor), run) for sensor in SENSORS]
    np.testing.assert_array_equal(column(Frequency(1), run), run.by_observation[:, :, 0].ravel())
    np.testing.assert_array_equal(column(Damping(1), run), run.by_parameter[:, :, 1].ravel())
    np.testing.assert_array_equal(gains[2], run.by_observation[:, :, 5].ravel())
    # the amplitude of a run is what all its sensors read
    np.testing.assert_allclose(column(Amplitude(1), run), sum(gains), atol=1e-14)
    np.testing.assert_array_equal(column(Amplitude(), run), column(Amplitude(1), run))


@pytest.mark.parametrize(
    "elsewhere",
    [Frequency(0), Damping(0), Amplitude(0), SensorGain(0, sensor=SENSORS[0]), SensorGain(sensor=("c.x", 1))],
)
def test_none_takes_anything_from_a_run_that_it_is_not_in(elsewhere: Direction, run: Matched) -> None:
    np.testing.assert_array_equal(column(elsewhere, run), np.zeros(run.residual.size))


def test_names_are_those_of_stored_comparisons() -> None:
    assert [kind.quantity for kind in KINDS] == ["frequency", "damping", "amplitude", "sensor"]
    assert list(OF_MODES) == [Frequency, Damping]


def test_of_one_sensor_no_gain_is_estimated_along_curves() -> None:
    estimated = [one for kind in KINDS for one in kind.along_curves(PLAN)]
    assert estimated == [Frequency(0), Frequency(1), Damping(0), Damping(1), *(SensorGain(sensor=s) for s in SENSORS)]
    alone = Plan(tuple(RunCondition("1 N", "first", 1.0, True, (40.0, 44.0), SENSORS[:1]) for _ in range(2)), ())
    assert SensorGain.along_curves(alone) == []


def test_of_two_sensors_one_is_held_against_the_other_at_tops_and_of_three_each() -> None:
    for count, wanted in ((1, 0), (2, 1), (3, 3)):
        sensors = [(point, 1) for point in "abc"[:count]]
        found = SensorGain.at_tops(4, sensors)
        assert [direction for direction, _ in found] == [SensorGain(4, sensor=s) for s in sensors[:wanted]]
        # what frequencies are, and what all heights share, is no sensor's
        assert all(row @ np.ones(2 * count) == pytest.approx(0) and not row[:count].any() for _, row in found)


@dataclass(frozen=True)
class Offset(OfSensors):
    """A kind of its own, as another one would be added."""

    quantity: ClassVar[str] = "offset"

    def prior(self, plan: Plan) -> float:
        return 0.1 * len(plan.conditions)

    def taken(self, m: Matched, sensors, parameters) -> np.ndarray:  # noqa: ARG002
        return np.ones_like(m.residual)

    def said(self, relative: float) -> str:
        return f"offset {relative:g} in all runs"

    def subject(self, plan, names, plural) -> tuple[str, str]:  # noqa: ARG002
        return "offset", ""


def test_a_new_kind_is_a_class_and_its_place_among_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(findings, "KINDS", (*KINDS, Offset))
    (said,) = findings.findings(None, PLAN, [Misfit(Offset(), 0.5, 0.01), Misfit(Frequency(0), 1e-4, 1e-3)])
    assert (said.text, said.quantity, said.level) == ("offset 0.5 in all runs", "offset", None)


def test_a_kind_that_does_not_say_what_it_takes_from_a_run_cannot_be_made() -> None:
    """An unknown kind had a column of zeros, and nobody was told."""

    @dataclass(frozen=True)
    class Unfinished(OfSensors):
        quantity: ClassVar[str] = "unfinished"

    with pytest.raises(TypeError, match="taken"):
        Unfinished()  # type: ignore[abstract]
