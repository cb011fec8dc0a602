"""A calibration rests on the numerical error of the model where it ends, not of the model as given."""

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.comparison.fit.gated_calibration import GatedCalibration, gated_calibration
from updamp.comparison.fit.numerical_gate import NumericalGate, finer_than
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.own_numerics import OwnNumericsOptions, farthest_moved
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.effects.rig_model import RigModel
from updamp.model.calibration import FRICTION, YOUNGS_MODULUS

# Of the friction coefficient's and the others' logarithms: with half the friction the contact slips far more.
TRUE = np.array([0.01, 0.3, -0.5, 0.0])


def finer() -> RigModel:
    return YOUNGS_MODULUS.apply(FRICTION.apply(small_model(), 0.7), 1.002)


@pytest.fixture(scope="module")
def plan() -> Plan:
    conditions = condition(10.0), condition(20.0)
    return synthetic_plan(Parametrisation(finer(), NUISANCES), TRUE, conditions, np.full(4, 1e-4), 2, noise=0.003)[0]


@pytest.fixture(scope="module")
def gate(plan: Plan) -> NumericalGate:
    return NumericalGate(plan, finer_than(small_model(), {"finer": finer()}))


PLAIN = Parametrisation(small_model(), NUISANCES)
WHERE_IT_BEGINS = OwnNumericsOptions(again=0)


@pytest.fixture(scope="module")
def found(gate: NumericalGate) -> GatedCalibration:
    return gated_calibration(PLAIN, gate, (0, 1))


def test_what_a_finer_model_changes_is_asked_for_where_the_calibration_ends(gate, found) -> None:
    begun = gated_calibration(PLAIN, gate, (0, 1), options=WHERE_IT_BEGINS)
    assert begun.calibration.fit.compared.mean_squared_misfit > 10
    assert 0.5 < found.calibration.fit.compared.mean_squared_misfit < 1.3
    assert len(found.before) == 2
    assert np.array_equal(found.before[0].u, np.zeros(len(found.before[0].u)))


def test_parameters_and_numerical_error_belong_to_each_other(gate, found) -> None:
    """Asked for once more where the calibration ends, the error leads nowhere else: to first order by no more than what
    is asked for, and in all by less than the parameters' deviations."""
    fitted, n = found.calibration.fit, len(PLAIN)
    again = gated_calibration(PLAIN, gate, (0, 1), fitted.u[:n], options=WHERE_IT_BEGINS).calibration.fit
    assert farthest_moved(fitted) <= OwnNumericsOptions().moved
    assert np.max(np.abs(again.u[:n] - fitted.u[:n]) / fitted.uncertainty[:n]) < 1


def test_it_is_asked_for_once_where_it_is_nothing(plan) -> None:
    gate = NumericalGate(plan, {})
    said: list[str] = []
    gated_calibration(Parametrisation(finer(), NUISANCES), gate, (0, 1), progress=said.append)
    assert "numerical error of the calibrated model" not in said
