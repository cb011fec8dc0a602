"""An effect of which two sizes explain the data: the fit that finds one of them is told of the other."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, small_model, synthetic_plan

from updamp.comparison.fit import fit
from updamp.comparison.fit.compared import objective
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.candidate_models.other_sizes import SIZE_FACTORS, as_likely, fit_from_size, have_two_signs
from updamp.diagnosis.candidate_models.refit import Starts, refit
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.fitted_parameters import fitted_parameters
from updamp.effects.effect import Effect, EffectParameter
from updamp.hbm.problem.structural_changes import Attachment

STIFFNESS = 1e4
ALIKE = 1.0, 2.2


def spring(model, size):
    return replace(
        model,
        attachments=(*model.attachments, Attachment("at b", points={"b.x": 1.0}, stiffness=STIFFNESS * size)),
    )


def effect(name, share_of):
    """A spring at b, as stiff as `share_of` its size says."""
    parameter = EffectParameter("size", 0.0, 0.0, 3.0, 1.0, "", "test")
    return Effect(
        name, "there is a spring", (parameter,), lambda model, values: spring(model, share_of(values["size"]))
    )


def chi_square(fit):
    return objective(fit.parametrisation, fit.compared)


PLAIN = effect("plain", lambda size: size)
TWOFOLD = effect("twofold", lambda size: size * (sum(ALIKE) - size) / (ALIKE[0] * ALIKE[1]))


@pytest.fixture
def fitted(monkeypatch):
    monkeypatch.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)

    def of(one):
        truth = Parametrisation(spring(small_model(), 1.0), NUISANCES)
        conditions = (condition(60.0),)
        plan, _ = synthetic_plan(truth, np.zeros(4), conditions, np.array([1e-4, 0.02, 0.02, 0.01]), seed=7)
        start = baseline(small_model(), (), plan, {})
        found = refit(start.fitted, plan, (one,), Starts((np.full(1, 0.8),), ()), Criteria(), full=True)
        return start, found

    return of


@pytest.mark.long
def test_the_other_minimum_is_found_is_as_likely_and_is_in_the_interval(fitted):
    start, found = fitted(TWOFOLD)
    (one,) = fitted_parameters(found, TWOFOLD)
    assert one.value == pytest.approx(ALIKE[0], rel=0.1)
    assert one.upper < ALIKE[1]
    other = fit_from_size(found.fitted, (TWOFOLD,), 2.0, start)
    assert other.parametrisation.values(other.u)["twofold"]["size"] == pytest.approx(ALIKE[1], rel=0.1)
    assert as_likely(other, found.fitted)
    # one model: nothing that verdicts go by may depend on the way that led there
    assert chi_square(other) == pytest.approx(chi_square(found.fitted), abs=0.5)
    (both,) = fitted_parameters(replace(found, also=(other,)), TWOFOLD)
    assert both.lower < ALIKE[0] < ALIKE[1] < both.upper


@pytest.mark.long
def test_where_there_is_one_minimum_every_size_leads_back_to_it(fitted, monkeypatch):
    start, found = fitted(PLAIN)
    for size in SIZE_FACTORS:
        assert fit_from_size(found.fitted, (PLAIN,), size, start) is None
    solved = []
    monkeypatch.setattr(fit, "predict_branches", lambda *each, **_: solved.append(each))
    assert fit_from_size(found.fitted, (PLAIN,), 1.05, start) is None
    assert not solved  # but the start: first order tells


def test_an_effect_that_has_no_sign_is_not_turned_round():
    both = replace(PLAIN, parameters=(EffectParameter("size", 0.0, -3.0, 3.0, 1.0, "", "test"),))
    assert not have_two_signs((PLAIN,))
    assert have_two_signs((both,))
    assert not have_two_signs((PLAIN, both))
