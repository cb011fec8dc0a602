"""A point that is unlike those next to it is named and left out, and none where points differ by chance or a curve
jumps."""

from dataclasses import replace

import numpy as np
import pytest
from support.held_beam import held_beam, of_beam
from support.small_model import NOISE, condition, parametrisation, swept_run, synthetic_plan
from support.softening_beam import DOWN, UP, at, softening_beam

from updamp.comparison.comparison import Comparison, OddPoint
from updamp.comparison.findings.odd_points import odd_points
from updamp.comparison.fit.compared import compare_at
from updamp.comparison.fit.fit_round import prior_scatter
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.odd_readings import odd_readings, without_odd
from updamp.comparison.prediction.run_condition import RunCondition
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
    return odd_points(odd_readings(compared, plan), plan, NAMES)


@pytest.mark.parametrize("point", [0, 9, 22])
def test_a_bad_sample_of_the_force_is_told_once_and_as_that(branches, point: int) -> None:
    """Both sensors read four times too much for it, and neither did."""
    plan = runs(seed=3)
    (found,) = named(with_force(plan, run=1, point=point, by=np.log(0.25)), branches)
    assert (found.channel, found.frequency) == ("the force", pytest.approx(plan.observations[1].frequency[point]))
    assert found.relative == pytest.approx(-0.75, abs=0.03)
    assert "the force at" in found.text
    assert "% low beside the points next to it" in found.text


def with_force(plan: Plan, run: int, point: int, by: float) -> Plan:
    changed = list(plan.observations)
    log_force = changed[run].log_force.copy()
    log_force[point] += by
    changed[run] = replace(changed[run], log_force=log_force)
    return replace(plan, observations=tuple(changed))


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
    assert "% low for the force there, beside the points next to it" in found.text


@pytest.mark.parametrize("point", [0, 9, 22, 37])
@pytest.mark.parametrize("other", [-0.25, 0.2])
def test_of_two_beside_each_other_both_are_named(branches, point: int, other: float) -> None:
    """Neither was: each made up for the other."""
    plan = with_odd(runs(seed=3), run=1, point=point, column=3, by=np.log(0.8))
    found = named(with_odd(plan, run=1, point=point + 1, column=3, by=other), branches)
    assert {one.run for one in found} == {CONDITIONS[1].name}
    wanted = plan.observations[1].frequency[[point, point + 1]]
    assert sorted(one.frequency for one in found) == pytest.approx(sorted(wanted))


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


@pytest.mark.parametrize("condition", [DOWN, UP], ids=["down", "up"])
def test_a_point_recorded_while_the_rig_jumped_is_named(condition: RunCondition) -> None:
    """Half-way between both parts, where it would cost more than all others together; none of a sound run."""
    beam = softening_beam()
    u, condition = at(beam), replace(condition, noise=(2e-6, NOISE, NOISE))
    branch = trace_branch(beam, u, condition)
    run = swept_run(branch, 0, 1, np.zeros(1), NOISE, np.random.default_rng(5), points=60)

    def odd(run: Observations) -> list[float]:
        plan = Plan((condition,), (run,))
        found = odd_readings(compare_at(beam, u, plan, [branch], prior_scatter(beam, plan)), plan)
        return [one.frequency for one in found]

    jump = int(np.argmax(np.abs(np.diff(run.observed[:, 1]))))
    changed = run.observed.copy()
    changed[jump, 1:] += np.diff(run.observed, axis=0)[jump, 1:] / 2
    assert odd(replace(run, observed=changed)) == [pytest.approx(run.frequency[jump])]
    assert odd(run) == []


SOUND = held_beam((80.40,) * 3, (0.003,) * 3)


@pytest.fixture(scope="module")
def of_sound() -> Comparison:
    return of_beam(SOUND)


@pytest.mark.parametrize(("at", "of"), [pytest.param(28, "response", marks=pytest.mark.long), (20, "force")])
def test_it_moves_nothing_that_is_told_wherever_it_lies(at: int, of: str, of_sound: Comparison) -> None:
    """Of the response at the top, which would be read off it; and of the force on a flank."""
    first, second, third = SOUND.runs
    changed = getattr(second, of).copy()
    changed[..., at] *= 3.0
    told = of_beam(replace(SOUND, runs=(first, replace(second, **{of: changed}), third)))
    (named,) = told.odd_points
    assert (named.run, named.frequency) == (second.name, pytest.approx(second.frequency[at]))
    assert "left out of calibration and findings" in named.text
    assert told.findings == of_sound.findings == ()
    assert told.values == of_sound.values - 2
    for one, other in zip(told.calibration, of_sound.calibration, strict=True):
        assert one.after == pytest.approx(other.after, abs=(other.upper - other.lower) / 4), "within a deviation"
    measured = next(pair.measured[0] for pair in told.curves if pair.run == second.name)
    assert len(measured.frequency) == len(second.frequency), "it is shown"


def test_what_is_left_out_is_left_out_at_all_sensors_of_that_run_alone() -> None:
    plan = with_odd(runs(seed=3), run=1, point=9, column=3, by=np.log(0.8))
    p = parametrisation()
    branches = [trace_branch(p, MISFIT, c) for c in CONDITIONS]
    odd = odd_readings(compare_at(p, MISFIT, plan, branches, prior_scatter(p, plan)), plan)
    left = without_odd(plan, odd)
    assert [len(o) - len(other) for o, other in zip(plan.observations, left.observations, strict=True)] == [
        int(i == 1) for i in range(len(plan.observations))
    ]
    assert np.array_equal(left.observations[1].observed, np.delete(plan.observations[1].observed, 9, axis=0))
    assert without_odd(plan, ()) is plan


def test_what_most_runs_show_alike_is_the_rigs_and_no_odd_point(branches) -> None:
    """As a mode that the model lacks, as narrow as a step, in whichever order its frequencies were measured; what half
    of them show is a matter of these runs."""
    seen = runs(seed=3)
    places = [4 if CONDITIONS[o.test].upwards else len(o) - 5 for o in seen.observations]
    for most in (True, False):
        plan = seen
        for run, place in enumerate(places[: None if most else len(places) // 2]):
            plan = with_odd(plan, run=run, point=place, column=3, by=np.log(0.6))
        assert len(named(plan, branches)) == (0 if most else len(places) // 2)


def test_the_flank_of_something_at_the_end_of_all_runs_is_the_rigs(branches) -> None:
    """Beside a neighbour that is off too no point is unlikely by itself: two of three repeats showed a flank with two
    points, one with its last alone, which was left out though all had it."""
    plan = runs(seed=3)
    for run, o in enumerate(plan.observations):
        at_end, before = (len(o) - 1, len(o) - 2) if CONDITIONS[o.test].upwards else (0, 1)
        plan = with_odd(plan, run=run, point=at_end, column=3, by=-1.0)
        if run:
            plan = with_odd(plan, run=run, point=before, column=3, by=-0.4)
    assert not named(plan, branches)
    alone = with_odd(runs(seed=3), run=0, point=len(plan.observations[0]) - 1, column=3, by=-1.0)
    assert len(named(alone, branches)) == 1
