"""A fit with an effect, and what speaks against it."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.diagnosis.effects.effect import Effect, EffectParameter
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.residual import numerical_gate
from updamp.diagnosis.search.baseline import baseline
from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.refit import Starts, refit
from updamp.hbm.structural_changes import Attachment


def apply(model, values):
    spring = Attachment("at b", points={"b.x": 1.0}, stiffness=3e4 * values["share"])
    return replace(model, attachments=(*model.attachments, spring))


SHARE = EffectParameter("share", 0.0, 0.0, 1.0, 0.5, "", "test")


@pytest.mark.parametrize(("ends", "said"), [((), "spring.share"), ((1.0,), "")])
def test_a_parameter_at_a_bound_is_told_unless_the_bound_makes_sense_itself(monkeypatch, ends, said):
    monkeypatch.setattr(numerical_gate, "nuisances", lambda _: NUISANCES)
    truth = Parametrisation(apply(small_model(), {"share": 1.3}), NUISANCES)
    plan, _ = synthetic_plan(truth, np.zeros(4), (condition(60.0),), np.array([1e-4, 0.02, 0.02, 0.01]), seed=3)
    effect = Effect("spring", "there is a spring", (replace(SHARE, ends=ends),), apply)
    start = baseline(small_model(), (), plan, {})
    found = refit(start.fitted, plan, (effect,), Starts((np.ones(1),), ()), Criteria(), full=True)
    assert found.fitted.parametrisation.values(found.fitted.u)["spring"]["share"] == pytest.approx(1.0, abs=1e-3)
    assert found.at_bound == said
