"""Fits that begin beside the model as given have the numerical error of the model as given."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.candidate_models.baseline import Baseline, baseline
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, fit_here
from updamp.diagnosis.criteria import Criteria
from updamp.effects.effect import Effect, EffectParameter
from updamp.hbm.problem.structural_changes import Attachment
from updamp.model.calibration import YOUNGS_MODULUS


def with_spring(model, values):
    spring = Attachment("at b", points={"b.x": 1.0}, stiffness=3e4 * values["share"])
    return replace(model, attachments=(*model.attachments, spring))


SPRING = Effect("spring", "a spring", (EffectParameter("share", 0.0, 0.0, 1.0, 0.5, "", "test"),), with_spring)


@pytest.fixture(scope="module")
def start() -> Baseline:
    """Of a rig with a spring more, and with a finer mesh that is stiffer. What it changes of the calibrated model is
    another error, though it is the same here, where calibration moves nothing far."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)
        finer = YOUNGS_MODULUS.apply(small_model(), 1.002)
        level = condition(60.0, window=(40.5, 46.0))
        truth = Parametrisation(with_spring(finer, {"share": 0.5}), NUISANCES)
        plan, _ = synthetic_plan(truth, np.zeros(4), (level,), np.array([1e-4, 0.02, 0.02, 0.01]), seed=5)
        found = baseline(small_model(), (), plan, {"finer": finer})
    p = found.fitted.parametrisation
    return replace(found, fitted=replace(found.fitted, parametrisation=replace(p, numerics=replace(p.numerics))))


def test_the_model_as_given_has_the_numerical_error_that_was_asked_for_there(start: Baseline) -> None:
    p, u = start.as_given
    assert p.numerics is start.given_numerics
    assert p.numerics is not start.fitted.parametrisation.numerics
    assert not np.any(p.numerics.about)
    assert len(u) == len(p)
    assert not np.any(u)


def test_with_an_effect_in_the_model_that_is_known_of_the_calibrated_one_alone(start: Baseline) -> None:
    fitted = start.fitted
    p = replace(fitted.parametrisation, effects=(SPRING,))
    with_effect = replace(start, fitted=replace(fitted, parametrisation=p))
    u = fitted.parametrisation.with_further(np.zeros(len(fitted.u)), np.array([0.7]))
    with_effect = replace(with_effect, fitted=replace(with_effect.fitted, compared=replace(fitted.compared, u=u)))
    found, at = with_effect.as_given
    assert found.numerics is fitted.parametrisation.numerics
    assert at[len(NUISANCES)] == 0.7
    assert np.count_nonzero(at) == 1


@pytest.mark.parametrize("as_given", [True, False])
def test_a_fit_keeps_the_numerical_error_of_where_it_begins(start: Baseline, as_given: bool) -> None:
    sizes = (np.ones(1),)
    task = FitTask((SPRING,), () if as_given else sizes, True, as_given=sizes if as_given else ())
    (found,) = fit_here(start, Criteria(), [task], lambda *_: None)
    expected = start.given_numerics if as_given else start.fitted.parametrisation.numerics
    p, u = found.refit.fitted.parametrisation, found.refit.fitted.u
    assert p.numerics is expected
    if as_given:
        assert found.trial.excess < 1.3
        assert p.values(u)["spring"]["share"] == pytest.approx(0.5, abs=3 * 0.5 * found.refit.fitted.uncertainty[4])
