"""A run that is unlike its repeats is named, and none where repeats differ by chance."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NOISE, NUISANCES, condition, parametrisation, synthetic_plan

from updamp.comparison.comparison import UnlikeRun
from updamp.comparison.findings.unlike_repeats import unlike_repeats
from updamp.comparison.fit.compared import compare_at
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.traced_branch import trace_branch

SCATTER = np.array([2e-4, 0.02, 0.03, 0.02])
CONDITIONS = (condition(20.0), condition(60.0), condition(60.0, upwards=False))
# what the model of the comparison gets wrong: common to all repeats
MISFIT = np.array([0.002, 0.1, -0.1, 0.0])


@pytest.fixture(scope="module")
def branches():
    p = parametrisation()
    return [trace_branch(p, MISFIT, c) for c in CONDITIONS]


def runs(seed: int, repeats: int = 3) -> Plan:
    p = parametrisation()
    return synthetic_plan(p, np.zeros(len(p)), CONDITIONS, SCATTER, seed, repeats=repeats)[0]


def named(plan: Plan, branches) -> tuple[UnlikeRun, ...]:
    scatter = Scatter(dict(zip((n.name for n in NUISANCES), SCATTER, strict=True)), drift=5e-5, gain=0.005)
    return unlike_repeats(compare_at(parametrisation(), MISFIT, plan, branches, scatter), scatter, plan)


def disturbed(plan: Plan, test: int, repeat: int, by: float) -> Plan:
    """One sensor reads high over the upper half of one run."""
    changed = []
    for o in plan.observations:
        if (o.test, o.repeat) == (test, repeat):
            observed = o.observed.copy()
            observed[observed[:, 0] > np.median(observed[:, 0]), 1] += by
            o = replace(o, observed=observed)
        changed.append(o)
    return replace(plan, observations=tuple(changed))


def test_the_disturbed_run_is_named_and_no_other(branches) -> None:
    plan = disturbed(runs(seed=1), test=1, repeat=2, by=10 * NOISE)
    (found,) = named(plan, branches)
    assert (found.run, found.repeat) == (CONDITIONS[1].name, 2)
    assert found.times > 2
    assert "60 N" in found.text
    assert "repeat 2" in found.text


@pytest.mark.long
def test_repeats_that_differ_by_chance_are_left_alone(branches) -> None:
    """Six measurements of nine runs whose assemblies differ, with a risk of a hundredth each: two have a run named with
    a probability of 0.0015."""
    plans = [runs(seed) for seed in range(100, 106)]
    assert sum(len(named(plan, branches)) > 0 for plan in plans) <= 1


def test_two_repeats_do_not_tell(branches) -> None:
    plan = disturbed(runs(seed=1, repeats=2), test=1, repeat=2, by=10 * NOISE)
    assert named(plan, branches) == ()
