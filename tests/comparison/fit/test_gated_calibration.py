"""A calibration rests on the numerical error of the model where it ends, not of the model as given."""

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.comparison.fit.gated_calibration import GateOptions, gated_calibration
from updamp.comparison.fit.numerical_gate import NumericalGate, finer_than
from updamp.comparison.fit.observations import Plan
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


@pytest.mark.parametrize(("again", "least", "most"), [(0, 50.0, np.inf), (3, 0.5, 1.3)])
def test_what_a_finer_model_changes_is_asked_for_where_the_calibration_ends(plan, again, least, most) -> None:
    gate = NumericalGate(plan, finer_than(small_model(), {"finer": finer()}))
    plain = Parametrisation(small_model(), NUISANCES)
    found = gated_calibration(plain, gate, (0, 1), options=GateOptions(again=again))
    assert least < found.calibration.fit.compared.mean_squared_misfit < most
    assert len(found.before) == 2
    assert np.array_equal(found.before[0].u, np.zeros(len(found.before[0].u)))


def test_it_is_asked_for_once_where_it_is_nothing(plan) -> None:
    gate = NumericalGate(plan, {})
    said: list[str] = []
    gated_calibration(Parametrisation(finer(), NUISANCES), gate, (0, 1), progress=said.append)
    assert "numerical error of the calibrated model" not in said
