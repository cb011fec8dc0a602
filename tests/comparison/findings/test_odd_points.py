"""A point that is unlike those next to it is named, and none where points differ by chance or a curve jumps."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NOISE, condition, parametrisation, synthetic_plan

from updamp.comparison.comparison import OddPoint
from updamp.comparison.findings.odd_points import odd_points
from updamp.comparison.fit.compared import compare_at
from updamp.comparison.fit.fit import prior_scatter
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.traced_branch import trace_branch

CONDITIONS = (condition(20.0), condition(60.0), condition(60.0, upwards=False))
NAMES = {"a.x": "left", "b.x": "right"}
# what the model of the comparison gets wrong
MISFIT = np.array([0.002, 0.1, -0.1, 0.0])


@pytest.fixture(scope="module")
def branches():
    p = parametrisation()
    return [trace_branch(p, MISFIT, c) for c in CONDITIONS]


def runs(seed: int) -> Plan:
    p = parametrisation()
    return synthetic_plan(p, np.zeros(len(p)), CONDITIONS, np.full(4, 1e-3), seed, repeats=2)[0]


def named(plan: Plan, branches) -> tuple[OddPoint, ...]:
    p = parametrisation()
    compared = compare_at(p, MISFIT, plan, branches, prior_scatter(p, plan))
    return odd_points(compared.matched, plan, NAMES)


def with_odd(plan: Plan, run: int, point: int, column: int, by: float) -> Plan:
    changed = list(plan.observations)
    observed = changed[run].observed.copy()
    observed[point, column] += by
    changed[run] = replace(changed[run], observed=observed)
    return replace(plan, observations=tuple(changed))


@pytest.mark.parametrize("point", [0, 9, 22, 38])
def test_a_point_that_reads_low_is_named_and_no_other(branches, point: int) -> None:
    plan = with_odd(runs(seed=3), run=1, point=point, column=3, by=np.log(0.8))
    (found,) = named(plan, branches)
    assert (found.run, found.repeat, found.channel) == (CONDITIONS[1].name, 1, "right")
    assert found.frequency == pytest.approx(plan.observations[1].frequency[point])
    assert found.relative == pytest.approx(-0.2, abs=0.03)
    assert "right at" in found.text
    assert "% low beside the points next to it" in found.text


def test_a_phase_is_named_in_degrees(branches) -> None:
    plan = with_odd(runs(seed=4), run=0, point=12, column=2, by=np.radians(-60.0))
    (found,) = named(plan, branches)
    assert found.channel == "left"
    assert found.degrees == pytest.approx(-60.0, abs=3.0)
    assert "degrees late" in found.text


def test_points_that_differ_by_chance_are_left_alone(branches) -> None:
    """Beside a model that is wrong by twenty times the noise, and beside its jump."""
    assert 0.05 * np.abs(MISFIT).max() > NOISE
    assert [len(named(runs(seed), branches)) for seed in range(6)] == [0] * 6
