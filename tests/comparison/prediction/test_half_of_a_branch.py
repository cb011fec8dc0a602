"""Comparisons solve half of a model that is its own mirror image: the same branch with the same derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from support.plain_rig import SHORT_FACES, SLIPPING, plain_model

from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.score_tests.signature import _needs_step
from updamp.effects.catalogue import CATALOGUE
from updamp.hbm.newton.equation import residual_alone
from updamp.model.calibration import nuisances

SENSORS = (("blade_left.tip.x", 1), ("blade_right.tip.x", 1))


@pytest.fixture(scope="module")
def model():
    return plain_model(SHORT_FACES, SLIPPING)


def with_gradient(model, mirrored):
    """Friction that falls up the faces. mirrored: whether half is solved"""
    p = Parametrisation(model, nuisances(model), (CATALOGUE["friction_gradient"],))
    assert p.mirrored
    p.__dict__["mirrored"] = mirrored
    u = np.zeros(len(p))
    u[-1] = 1.0
    return p, u


@pytest.fixture(scope="module")
def condition(model):
    """Through a resonance at which contacts slip."""
    frequency = model.system.stuck.frequencies[0]
    return RunCondition("OOP", "OOP", 10.0, True, (0.995 * frequency, 1.005 * frequency), SENSORS)


@pytest.fixture(scope="module")
def branches(model, condition):
    return [trace_branch(*with_gradient(model, mirrored), condition) for mirrored in (True, False)]


def shown(branch, frequency):
    """States and slopes (n, ...) there; of a branch without turning points"""
    f = np.exp(branch.state[:, 0])
    return (
        np.array([np.interp(frequency, f, c) for c in part.reshape(len(f), -1).T])
        for part in (branch.state, branch.slopes)
    )


def test_half_of_the_rows_are_solved_for(branches, model):
    half, whole = branches
    assert whole.points[0].x.shape[0] == model.components.n_relative
    assert half.points[0].x.shape[0] < 0.6 * model.components.n_relative


def test_what_is_solved_solves_the_whole(branches, model):
    there = ModelAt(*with_gradient(model, True))
    system, excitation = there.model.system, there.model.excited_by(10.0)
    for point in branches[0].points:
        left = residual_alone(system, excitation, there.whole(point.x), point.w)
        assert np.abs(left).max() < 1e-8 * np.abs(point.x).max()


def test_the_branch_and_its_derivatives_are_those_of_the_whole(branches, model):
    half, whole = branches
    moved = [move_branch(*moved_by(model, m), b) for m, b in ((True, half), (False, whole))]
    for one, other in (branches, moved):
        frequency = np.exp(one.state[3:-3, 0])
        for found, expected in zip(shown(one, frequency), shown(other, frequency), strict=True):
            np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())


def moved_by(model, mirrored):
    p, u = with_gradient(model, mirrored)
    return p, u + np.array([1e-3, 0.1, 0.1, 0.05, 0.05, 0.1, -0.3])


def test_an_effect_that_takes_the_symmetry_is_solved_whole(branches, model, condition):
    askew = CATALOGUE["pressure_slope"]
    p = Parametrisation(model, nuisances(model), (askew,))
    assert not p.mirrored
    branch = trace_branch(p, np.zeros(len(p)), condition)
    assert branch.points[0].x.shape[0] == model.components.n_relative
    u = np.append(np.zeros(len(p) - 1), 1.0)
    assert move_branch(p, u, replace(branches[0], u=np.zeros(len(p)))) is None, "of another effect: traced anew"


# slopes leap where tips begin to slip, between the points of either branch, so that lines between these differ more
@pytest.mark.parametrize(
    ("name", "apart"), [("pressure_slope", 2e-3), ("blade_cubic_stiffness", 2e-3), ("tip_friction", 3e-3)]
)
def test_a_branch_is_moved_to_where_an_effect_takes_the_symmetry_or_brings_elements(model, condition, name, apart):
    plain = Parametrisation(model, nuisances(model))
    with_effect = replace(plain, effects=(CATALOGUE[name],))
    u = np.zeros(len(with_effect))
    u[len(plain) :] = 1.0
    before = trace_branch(plain, np.zeros(len(plain)), condition)
    moved, traced = move_branch(with_effect, u, before), trace_branch(with_effect, u, condition)
    assert moved is not None
    assert len(moved.points[0].x) > len(before.points[0].x)
    there = ModelAt(with_effect, u)
    excitation = there.model.excited_by(condition.force)
    for point in moved.points:
        left = residual_alone(there.model.system, excitation, there.whole(point.x), point.w)
        assert np.abs(left).max() < 1e-6 * np.abs(point.x).max(), "as well as branches are moved"
    states, expected = (next(shown(b, np.linspace(*condition.window, 50))) for b in (moved, traced))
    np.testing.assert_allclose(states, expected, atol=apart * np.abs(expected[1:]).max())


def test_beside_half_a_model_what_takes_the_symmetry_has_no_derivative(model):
    there = ModelAt(*with_gradient(model, True))
    askew = replace(CATALOGUE["pressure_slope"], finite_step=False)
    assert _needs_step(there, askew)
    assert not _needs_step(there, CATALOGUE["pressure_crown"])
