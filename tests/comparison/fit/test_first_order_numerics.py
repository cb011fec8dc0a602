"""What finer numerics change is known to first order about the parameters where it was asked for."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import condition, parametrisation, small_model, synthetic_plan

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import Fit, fit
from updamp.comparison.fit.fit_round import prior_scatter
from updamp.comparison.fit.matching import across
from updamp.comparison.fit.numerical_gate import NumericalGate
from updamp.comparison.fit.numerical_patterns import change_to
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.own_numerics import farthest_moved
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.rig_model import RigModel
from updamp.hbm.harmonics import Harmonics

STEP = np.array([0.02, -0.3, 0.2, 0.15])  # of Young's modulus, loss factor, friction, preload
DEVIATIONS = np.array([1e-4, *4 * (0.005,)])  # that differences are told in


def finer() -> RigModel:
    """A model whose contact is a third softer, with more harmonics: what it changes depends on all parameters."""
    model = small_model()
    law = model.contacts.parameters
    softer = replace(model.contacts, parameters=law._replace(kt=0.7 * law.kt))
    return replace(model, contacts=softer, harmonics=Harmonics((1, 3, 5)), time_samples=256)


@pytest.fixture(scope="module")
def plan() -> Plan:
    plain = parametrisation()
    return synthetic_plan(plain, np.zeros(4), (condition(30.0),), np.full(4, 1e-4), seed=2)[0]


@pytest.fixture(scope="module")
def gated(plan) -> Parametrisation:
    return NumericalGate(plan, {"softer": finer()}).at(parametrisation(), np.zeros(4)).parametrisation


def left_by(numerics, plan: Plan, step: np.ndarray) -> float:
    """RMS across the branch of what the model with this error differs from the finer
    one by, at these parameters"""
    p = replace(parametrisation(), numerics=numerics)
    (branch,) = predict_branches(p, np.append(step, np.zeros(len(p) - 4)), plan)
    shown = branch.evenly
    exact = trace_branch(replace(parametrisation(), base=finer()), step, condition(30.0, window=(38.0, 52.0)))
    left, _ = change_to(shown.value, exact, branch.condition)
    # where a contact begins to slip both are known as well as one branch is jagged beside the other
    basis = across(shown.along, np.hypot(DEVIATIONS, branch.rough_at(branch.even_places)))
    in_window = abs(np.exp(shown.value[:, 0]) - 45.0) < 5.0
    return float(np.sqrt(np.mean(np.einsum("nrm,nm->nr", basis, left)[in_window] ** 2)))


def test_with_it_the_model_follows_the_finer_one_to_first_order(plan, gated):
    """Beside contacts that begin to slip somewhere else a little less than the square of the step is left."""
    known, held = gated.numerics, gated.numerics.held_at(np.zeros(4))
    assert left_by(known, plan, 0 * STEP) < 0.2
    first, first_half = (left_by(known, plan, step) for step in (STEP, STEP / 2))
    none, none_half = (left_by(held, plan, step) for step in (STEP, STEP / 2))
    assert first < none / 2
    assert first > 2.7 * first_half
    assert none < 2.1 * none_half


def test_how_far_parameters_are_off_where_it_is_held_is_known_without_a_fit(gated):
    """Of runs of the finer model, with other parameters than those where it was asked for"""
    truth = replace(parametrisation(), base=finer())
    plan, _ = synthetic_plan(truth, STEP, (condition(30.0),), np.zeros(4), seed=3, repeats=1)
    held = replace(gated, numerics=gated.numerics.held_at(np.zeros(4)))
    found, off = (fit(p, plan, np.zeros(len(p))) for p in (gated, held))
    moved = np.abs(off.u - found.u)[:4] / found.uncertainty[:4]
    assert moved.max() > 0.8
    assert farthest_moved(found) == pytest.approx(moved.max(), rel=0.3)


def test_beyond_the_ends_of_what_it_was_asked_for_nothing_is_known():
    """A run on one flank, and a model so much stiffer than it was that the run lies nearer its resonance."""
    flank = condition(30.0, window=(40.0, 41.5))
    on_flank, _ = synthetic_plan(parametrisation(), np.zeros(4), (flank,), np.zeros(4), seed=2, repeats=1)
    p = NumericalGate(on_flank, {"softer": finer()}).at(parametrisation(), np.zeros(4)).parametrisation
    softer = np.append([-0.05, 0.0, 0.0, 0.0], np.zeros(len(p) - 4))
    (branch,) = predict_branches(p, softer, on_flank)
    compared = compare_at(p, softer, on_flank, (branch,), prior_scatter(p, on_flank))
    found = Fit(p, compared, np.eye(len(p)), "")
    assert farthest_moved(found) == np.inf
