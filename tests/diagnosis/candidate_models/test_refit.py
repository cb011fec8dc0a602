"""A fit with an effect, and what speaks against it."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.candidate_models.baseline import baseline, with_own_numerics
from updamp.diagnosis.candidate_models.candidate_fits import FitContext
from updamp.diagnosis.candidate_models.fit_tasks import FitTask, fit_here
from updamp.diagnosis.candidate_models.refit import FULL, Starts, refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.selection.single_effects import refits_with_own_numerics
from updamp.effects.effect import Effect, EffectParameter
from updamp.hbm.problem.structural_changes import Attachment

# The resonance and its flanks, whose branches take half as long as those of 40 to 50 Hz.
LEVEL = condition(60.0, window=(40.5, 46.0))


def with_share(model, values):
    spring = Attachment("at b", points={"b.x": 1.0}, stiffness=3e4 * values["share"])
    return replace(model, attachments=(*model.attachments, spring))


SHARE = EffectParameter("share", 0.0, 0.0, 1.0, 0.5, "", "test")


@pytest.mark.parametrize(("ends", "said"), [((), "spring.share"), ((1.0,), "")])
def test_a_parameter_at_a_bound_is_told_unless_the_bound_makes_sense_itself(monkeypatch, ends, said):
    monkeypatch.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)
    truth = Parametrisation(with_share(small_model(), {"share": 1.3}), NUISANCES)
    plan, _ = synthetic_plan(truth, np.zeros(4), (condition(60.0),), np.array([1e-4, 0.02, 0.02, 0.01]), seed=3)
    effect = Effect("spring", "there is a spring", (replace(SHARE, ends=ends),), with_share)
    start = baseline(small_model(), (), plan, {})
    found = refit(start.fitted, plan, (effect,), Starts((np.ones(1),), ()), Criteria(), full=True)
    assert found.fitted.parametrisation.values(found.fitted.u)["spring"]["share"] == pytest.approx(1.0, abs=1e-3)
    assert found.at_bound == said


# An effect that a finer mesh shows differently, though the model without it is the same on both.

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


@pytest.mark.long
def test_a_fit_that_leaves_a_misfit_of_its_mesh_explains_the_data_once_that_is_known(monkeypatch):
    monkeypatch.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)
    truth = Parametrisation(apply(FINE, {"size": 1.0}), NUISANCES)
    conditions = (replace(LEVEL, name="10 N", force=10.0), LEVEL)
    plan, _ = synthetic_plan(truth, np.zeros(4), conditions, np.array([1e-4, 0.02, 0.02, 0.01]), seed=7)
    starts = Starts((np.ones(1),), ())
    start = baseline(small_model(), (), plan, {"fine": FINE})
    found = refit(start.fitted, plan, (SPRING,), starts, Criteria(), full=True)
    again = with_own_numerics(found.fitted, start, FULL)
    # what the right model leaves: sensors, and the interpolation between points of a single contact's branch
    right = replace(start.fitted, parametrisation=replace(start.fitted.parametrisation, base=FINE))
    least = refit(right, plan, (SPRING,), starts, Criteria(), full=True).mean_squared_misfit
    assert found.mean_squared_misfit > 20 * least
    assert again.compared.mean_squared_misfit < 2 * least  # what the mesh changes was found where the first fit ended
    assert again.parametrisation.values(again.u)["spring"]["size"] == pytest.approx(1.0, rel=0.1)


def shown_weakly(model, values):
    """A spring at b of the size; where that is positive a coarse mesh shows half of it, and where it is negative
    it comes with one at a."""
    size = values["size"]
    share = 1.0 if size < 0 or "fine" in model.notes else 0.5
    springs = [Attachment("at b", points={"b.x": 1.0}, stiffness=STIFFNESS * share * abs(size))]
    if size < 0:
        springs.append(Attachment("at a", points={"a.x": 1.0}, stiffness=0.3 * STIFFNESS * abs(size)))
    return replace(model, attachments=(*model.attachments, *springs))


WEAKLY = Effect(
    "spring", "there is a spring", (EffectParameter("size", 0.0, -3.0, 3.0, 1.0, "", "test"),), shown_weakly
)


@pytest.mark.long
def test_a_fit_that_ended_at_the_wrong_sign_is_turned_round(monkeypatch):
    monkeypatch.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)
    truth = Parametrisation(shown_weakly(FINE, {"size": 1.0}), NUISANCES)
    plan, _ = synthetic_plan(truth, np.zeros(4), (LEVEL,), np.array([1e-4, 0.02, 0.02, 0.01]), seed=7)
    start, criteria = baseline(small_model(), (), plan, {"fine": FINE}), Criteria()
    (found,) = fit_here(start, criteria, [FitTask((WEAKLY,), (-np.ones(1),), full=True)], lambda *_: None)
    assert found.refit.fitted.u[found.refit.fitted.parametrisation.columns("spring")] < 0
    tries = [
        FitTask((WEAKLY,), (), True, near=found.refit.fitted, own_numerics=True, size=size) for size in (1.0, -1.0)
    ]
    same, turned = fit_here(start, criteria, tries, lambda *_: None)
    best = refits_with_own_numerics(FitContext(start, criteria, lambda _: None, fit_here), {("spring",): found})[
        ("spring",)
    ]
    assert same.refit.drop < turned.refit.drop == pytest.approx(best.refit.drop)
    fitted = best.refit.fitted
    size = fitted.parametrisation.columns("spring").start
    # the coarse mesh shows half of it, and all of what that lacks is unsure: half of the size
    assert 0.4 < fitted.uncertainty[size] < 0.6
    assert fitted.u[size] == pytest.approx(1.0, abs=fitted.uncertainty[size])
