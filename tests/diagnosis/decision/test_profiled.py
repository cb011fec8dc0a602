"""Which intervals are made by profile likelihood, and that they are those that the verdict has."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import pytest

from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.decision import profiled
from updamp.diagnosis.decision.decide import Decision
from updamp.diagnosis.decision.fitted_parameters import fitted_parameters
from updamp.diagnosis.decision.profiled import profiles, with_profiles
from updamp.diagnosis.evidence import Trial
from updamp.effects.effect import Effect, EffectParameter
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.newton.newton import Status

SPRING = Effect(
    "spring", "there is a spring", (EffectParameter("stiffness", 0.0, -10.0, 10.0, 2.0, "N", ""),), lambda m, _: m
)
DAMPING = Effect(
    "damping", "it loses energy",
    (EffectParameter("loss", 1.0, -10.0, 10.0, -1.0, "", ""), EffectParameter("power", 0.0, -10.0, 10.0, 1.0, "", "")),
    lambda m, _: m,
)  # fmt: skip


@dataclass(frozen=True)
class Found:
    refits: dict
    baseline: SimpleNamespace


def refit(*effects: Effect) -> Refit:
    """Of values half way to the typical ones, with deviations of a tenth"""
    places, n = {}, 0
    for e in effects:
        places[e.name] = slice(n, n + len(e.parameters))
        n += len(e.parameters)
    values = {e.name: {q.name: q.null + 0.5 * (q.typical - q.null) for q in e.parameters} for e in effects}
    p = SimpleNamespace(effects=effects, columns=places.get, values=lambda _: values)
    fitted = SimpleNamespace(parametrisation=p, u=[0.5] * n, uncertainty=[0.1] * n)
    return Refit(effects, fitted, 100.0, 100.0, "")


def trial(*names: str) -> Trial:
    return Trial(names, 0.9, 100.0, 100.0, 0.9, "", True)


@pytest.fixture
def found(monkeypatch):
    """A search whose profiles go from 0.2 to 0.9 of a typical size, but for a power, without a response"""

    def profile(fitted, _plan, place):
        if len(fitted.u) == 2 and place == 1:
            raise BranchStoppedError(80.0, 1.0, Status.STALLED)
        return SimpleNamespace(interval=(0.2, 0.9))

    monkeypatch.setattr(profiled, "profile", profile)
    monkeypatch.setattr(profiled, "without_branches", lambda fitted: fitted)
    refits = {("spring",): refit(SPRING), ("damping",): refit(DAMPING), ("spring", "damping"): refit(SPRING, DAMPING)}
    return Found(refits, SimpleNamespace(train_plan=None))


def test_they_are_made_of_what_the_verdict_rests_on_and_of_what_is_not_told_from_it(found):
    alone = Decision("identified", ("spring",), (), trial("spring"))
    either = replace(alone, outcome="inseparable", alternatives=(trial("spring"), trial("damping")))
    assert profiles(found, Decision("adequate", (), (), None)) == {}
    assert profiles(found, alone) == {("spring",): {"spring.stiffness": pytest.approx((0.4, 1.8))}}
    assert list(profiles(found, either)) == [("spring",), ("damping",)]
    both = profiles(found, Decision("identified", ("spring", "damping"), (), trial("spring", "damping")))
    assert list(both["spring", "damping"]) == ["spring.stiffness", "damping.loss", "damping.power"]


def test_those_of_a_verdict_are_these_and_by_derivatives_where_there_are_none(found):
    """The loss is 1 where there is none and -1 where it is typical."""
    decision = Decision("identified", ("damping",), (), trial("damping"))
    known = with_profiles(found, profiles(found, decision))
    loss, power = fitted_parameters(known.refits["damping",], DAMPING)
    assert (loss.lower, loss.upper) == pytest.approx((-0.8, 0.6))
    assert (power.lower, power.upper) == pytest.approx((0.5 - 0.196, 0.5 + 0.196))
    (stiffness,) = fitted_parameters(known.refits["spring",], SPRING)
    assert (stiffness.lower, stiffness.upper) == pytest.approx((1 - 0.392, 1 + 0.392))
