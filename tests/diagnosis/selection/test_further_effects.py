"""When a third effect and more are looked for, with made-up fits."""

from types import SimpleNamespace

import pytest

from updamp.diagnosis.candidate_models.candidate_fits import FitContext
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate, fit_here
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.evidence import Trial
from updamp.diagnosis.selection import further_effects as module
from updamp.diagnosis.selection.further_effects import further_effects

PAIR = ("spring", "background")


def candidate(names, excess, held_out=2.0, gain=100.0):
    refit = SimpleNamespace(effects=names, delta_bic=gain, drop=1e3)
    return {names: FittedCandidate(refit, Trial(names, excess, 1e3, gain, held_out, "", True))}


def context(contacts=None):
    base = SimpleNamespace(contacts=contacts)
    fitted = SimpleNamespace(parametrisation=SimpleNamespace(base=base))
    start = SimpleNamespace(fitted=fitted, train_plan=SimpleNamespace(independent=40.0))
    return FitContext(start, Criteria(), lambda _: None, fit_here)


@pytest.fixture
def asked(monkeypatch):
    """What was asked for beside what, with answers by the number of effects."""
    calls, answers = [], {}

    def beside(_fits, first, _effects, fewer):
        calls.append((first.effects, len(fewer)))
        return answers.get(len(first.effects) + 1, {})

    monkeypatch.setattr(module, "beside", beside)
    return calls, answers


def test_effects_are_added_one_by_one_until_the_data_are_explained(asked):
    calls, answers = asked
    three, four = (*PAIR, "phase"), (*PAIR, "phase", "loss")
    answers |= {
        3: candidate(three, 9.0, 1.5) | candidate((*PAIR, "gain"), 8.0, gain=50.0),
        4: candidate(four, 1.0, 1.0),
    }
    found = further_effects(context(), (), {}, candidate(PAIR, 20.0) | candidate(("spring", "loss"), 30.0))
    assert calls == [(PAIR, 2), (three, 4)]
    assert set(found) == {three, (*PAIR, "gain"), four}


def test_an_effect_that_stood_in_for_another_is_left_out_again(monkeypatch):
    """A background and micro-slip are likeliest, a spring with them fails; beside background and spring quadratic loss
    explains all."""
    likeliest, other = ("background", "microslip"), ("background", "spring")
    found = {
        likeliest: candidate((*likeliest, "spring"), 2.3) | candidate((*likeliest, "loss"), 20.0, gain=10.0),
        other: candidate((*other, "microslip"), 2.4) | candidate((*other, "loss"), 1.0, gain=200.0),
    }
    calls = []

    def beside(_fits, first, _effects, _fewer):
        calls.append(first.effects)
        return found[first.effects]

    monkeypatch.setattr(module, "beside", beside)
    pairs = (
        candidate(likeliest, 25.0) | candidate(other, 50.0, gain=90.0) | candidate(("spring", "loss"), 60.0, gain=5.0)
    )
    result = further_effects(context(), (), {}, pairs)
    assert calls == [likeliest, other]
    assert set(result) == {(*likeliest, "spring"), (*likeliest, "loss"), (*other, "loss")}


@pytest.mark.parametrize(
    ("third", "why"),
    [
        (candidate((*PAIR, "phase"), 9.0, held_out=1.99), "held-out runs are not predicted better"),
        (candidate((*PAIR, "phase"), 9.0, 1.0, gain=5.0), "the data do not ask for it"),
        ({}, "there is none"),
    ],
)
def test_no_effect_is_added_to_one_that_does_not_help(asked, third, why):
    calls, answers = asked
    answers[3] = third
    assert further_effects(context(), (), {}, candidate(PAIR, 20.0)) == third, why
    assert calls == [(PAIR, 1)]


def test_nothing_is_added_to_a_pair_that_explains_the_data_or_helps_nothing(asked):
    calls, _ = asked
    assert further_effects(context(), (), {}, candidate(PAIR, 1.0)) == {}
    assert further_effects(context(), (), {}, candidate(PAIR, 20.0, gain=5.0)) == {}
    assert further_effects(context(), (), {}, {}) == {}
    assert calls == []


def test_models_with_contacts_have_two_effects_at_most(asked):
    calls, _ = asked
    assert further_effects(context(contacts=object()), (), {}, candidate(PAIR, 20.0)) == {}
    assert calls == []
