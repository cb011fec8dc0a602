"""An effect that a finer mesh shows differently, though the model without it is the same on both."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.diagnosis.effects.effect import Effect, EffectParameter
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.residual import numerical_gate
from updamp.diagnosis.search.baseline import baseline
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.refit import FULL, Starts, refit
from updamp.diagnosis.search.regate import gated_again
from updamp.hbm.structural_changes import Attachment

STIFFNESS = 1e4
FINE = replace(small_model(), notes={"fine": 1.0})


def apply(model, values):
    """A spring at b, and beside it one at a that only the finer mesh resolves."""
    k = STIFFNESS * values["size"]
    springs = [Attachment("at b", points={"b.x": 1.0}, stiffness=k)]
    if "fine" in model.notes:
        springs.append(Attachment("at a", points={"a.x": 1.0}, stiffness=0.4 * k))
    return replace(model, attachments=(*model.attachments, *springs))


SPRING = Effect("spring", "there is a spring", (EffectParameter("size", 0.0, 0.0, 5.0, 1.0, "", "test"),), apply)


def test_a_fit_that_leaves_a_misfit_of_its_mesh_explains_the_data_once_that_is_known(monkeypatch):
    monkeypatch.setattr(numerical_gate, "nuisances", lambda _: NUISANCES)
    truth = Parametrisation(apply(FINE, {"size": 1.0}), NUISANCES)
    conditions = tuple(condition(f) for f in (10.0, 60.0))
    plan, _ = synthetic_plan(truth, np.zeros(4), conditions, np.array([1e-4, 0.02, 0.02, 0.01]), seed=7)
    starts = Starts((np.ones(1),), ())
    start = baseline(small_model(), (), plan, {"fine": FINE})
    found = refit(start.fitted, plan, (SPRING,), starts, Criteria(), full=True)
    again = gated_again(found.fitted, start, FULL)
    # what the right model leaves: sensors, and the interpolation between points of a single contact's branch
    right = replace(start.fitted, parametrisation=replace(start.fitted.parametrisation, base=FINE))
    least = refit(right, plan, (SPRING,), starts, Criteria(), full=True).excess
    assert found.excess > 20 * least
    assert again.compared.excess < 2 * least  # what the mesh changes was found where the first fit ended
    assert again.parametrisation.values(again.u)["spring"]["size"] == pytest.approx(1.0, rel=0.1)
