"""Friction that changes from run to run: each test is predicted as the model was then."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, parametrisation, small_model, synthetic_plan

from updamp.comparison.fit.fit import FitOptions, fit
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.score_tests.signature import extend
from updamp.effects.catalogue import CATALOGUE
from updamp.model.calibration import FRICTION

EFFECT = CATALOGUE["friction_running_in"]
GROWTH, TYPICAL = 0.4, EFFECT.parameters[0].typical
# With slip at every one of them, in no order of the levels.
PLACES = {60.0: -0.5, 45.0: 0.5, 75.0: 0.0}
CONDITIONS = tuple(replace(condition(force), place=place) for force, place in PLACES.items())
RUNNING_IN = Parametrisation(small_model(), NUISANCES, (EFFECT,))
FRICTION_AT = NUISANCES.index(FRICTION)


def with_growth(growth):
    return np.array([0.0, 0, 0, 0, growth / TYPICAL])


@pytest.mark.parametrize("test", CONDITIONS[:2], ids=["first", "last"])
def test_a_branch_is_that_of_the_friction_then(test):
    found = trace_branch(RUNNING_IN, with_growth(GROWTH), test)
    u = np.zeros(4)
    u[FRICTION_AT] = GROWTH * test.place
    np.testing.assert_allclose(found.state, trace_branch(parametrisation(), u, test).state, rtol=1e-12)
    by_friction, by_growth = found.slopes[:, FRICTION_AT], found.slopes[:, 4]
    assert np.abs(by_friction).max() > 0.05
    np.testing.assert_allclose(by_growth, test.place * TYPICAL * by_friction, atol=1e-4 * np.abs(by_friction).max())


def test_where_the_order_is_not_known_nothing_changes():
    unknown = replace(CONDITIONS[1], place=0.0)
    found = trace_branch(RUNNING_IN, with_growth(GROWTH), unknown)
    np.testing.assert_array_equal(found.state, trace_branch(parametrisation(), np.zeros(4), unknown).state)
    assert not found.slopes[:, 4].any()


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(RUNNING_IN, with_growth(GROWTH), CONDITIONS, np.zeros(5), 3)[0]


@pytest.fixture(scope="module")
def calibrated(plan):
    return fit(parametrisation(), plan, np.zeros(4), options=FitOptions(rounds=6))


def test_its_signature_is_the_derivative_of_a_fit_with_it(plan, calibrated):
    extended = extend(calibrated, plan, (EFFECT,))
    for found in extended.compared.branches:
        expected = trace_branch(RUNNING_IN, np.append(calibrated.u, 0.0), found.condition)
        frequency = np.linspace(*found.condition.window, 50)
        one, other = (
            np.array([np.interp(frequency, np.exp(b.state[:, 0]), column) for column in b.slopes[:, 4].T])
            for b in (found, expected)
        )
        # interpolated between some of the points; it jumps where the contact begins to slip
        off = np.abs(one - other).max(axis=0)
        assert np.quantile(off, 0.9) <= 0.01 * np.abs(other).max()


@pytest.mark.long
def test_a_fit_finds_the_growth(plan, calibrated):
    found = fit(RUNNING_IN, plan, np.append(calibrated.u, 0.0))
    growth, deviation = found.u[4] * TYPICAL, found.deviations[4] * TYPICAL
    assert abs(growth - GROWTH) < 3 * deviation
    assert deviation < 0.1 * GROWTH
    assert found.compared.mean_squared_misfit < 1.2 < 2 < calibrated.compared.mean_squared_misfit
