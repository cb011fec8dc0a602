"""A branch moved onto what an effect brings, harmonics or elements of its own: the curve that a trace of it is."""

import numpy as np
import pytest
from support.plain_rig import SHORT_FACES, SLIPPING, plain_model

from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.catalogue import CATALOGUE
from updamp.model.calibration import nuisances

SENSORS = (("blade_left.tip.x", 1), ("blade_right.tip.x", 1))


@pytest.fixture(scope="module")
def plain():
    model = plain_model(SHORT_FACES, SLIPPING)
    return Parametrisation(model, nuisances(model), ())


@pytest.fixture(scope="module")
def before(plain):
    """Through a resonance at which contacts slip."""
    frequency = plain.base.system.stuck.frequencies[0]
    condition = RunCondition("OOP", "OOP", 20.0, False, (0.97 * frequency, 1.003 * frequency), SENSORS)
    return trace_branch(plain, np.zeros(len(plain)), condition)


@pytest.mark.parametrize("name", ["static_dynamic_coupling", "tip_friction"])
def test_a_moved_branch_is_the_traced_one(plain, before, name):
    effect = CATALOGUE[name]
    extended = Parametrisation(plain.base, plain.nuisances, (effect,))
    u = plain.with_further(before.u, np.ones(len(effect.parameters)))
    moved, traced = move_branch(extended, u, before), trace_branch(extended, u, before.condition)
    assert moved is not None
    tops = [np.abs(branch.amplitude[:, 0]).max() for branch in (before, traced)]
    assert abs(tops[1] / tops[0] - 1) > 0.003
    dense = traced.at(np.linspace(traced.place[0], traced.place[-1], 20_000)).value
    low, high = before.condition.window
    inside = moved.place[(moved.frequency > low) & (moved.frequency < high)]
    apart = [np.abs(dense - value).max(axis=1).min() for value in moved.at(inside).value]
    assert np.median(apart) < 3e-4
    assert max(apart) < 5e-3
