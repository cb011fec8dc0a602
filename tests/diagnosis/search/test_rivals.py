"""Which explanations are left to be told apart, for each outcome."""

from types import SimpleNamespace

import pytest

from updamp.diagnosis.search.criteria import Criteria
from updamp.diagnosis.search.decide import Decision
from updamp.diagnosis.search.evidence import Evidence, Trial
from updamp.diagnosis.search.rivals import NOTHING, rivals

NAN = float("nan")


def trial(*effects, excess, delta_bic=50.0, full=True, drop=100.0):
    return Trial(effects, excess, drop, delta_bic, NAN, "", full)


def found(*trials):
    """Fits stand for themselves by the names of their effects."""
    singles, pairs = ([t for t in trials if len(t.effects) == n] for n in (1, 2))
    evidence = Evidence(9.0, 9.0, 1.0, (), tuple(singles), tuple(pairs), ())
    baseline = SimpleNamespace(fitted="calibrated")
    refits = {t.effects: SimpleNamespace(fitted="+".join(t.effects)) for t in trials}
    return SimpleNamespace(baseline=baseline, refits=refits, evidence=evidence)


def of(outcome, group=(), *trials):
    return rivals(found(*trials), Decision(outcome, group[:1], group, None), Criteria())


def test_a_group_is_told_apart_and_nobody_else():
    trials = trial("a", excess=1.1), trial("b", excess=1.0), trial("c", excess=1.05), trial("b", "c", excess=0.9)
    assert of("inseparable", ("b", "a"), *trials) == {"b": "b", "a": "a"}


def test_where_all_fail_those_that_fail_least():
    trials = trial("a", excess=4.0), trial("b", excess=6.5), trial("c", excess=3.0, full=False)
    assert of("unknown", (), *trials) == {}
    both = trial("b", "a", excess=3.9)
    assert of("unknown", (), *trials, both) == {"b and a": "b+a", "a": "a"}
    many = [trial(name, excess=4.0 + i / 10) for i, name in enumerate("defg")]
    assert list(of("unknown", (), *many)) == ["d", "e", "f"]


@pytest.mark.parametrize(("delta_bic", "wanted"), [(50.0, {NOTHING: "calibrated", "a": "a"}), (5.0, {})])
def test_an_effect_that_the_data_of_the_fit_ask_for_stands_against_nothing(delta_bic, wanted):
    assert (
        of("adequate", (), trial("a", excess=1.0, delta_bic=delta_bic), trial("b", excess=0.9, delta_bic=1)) == wanted
    )


def test_nothing_is_to_be_told_apart_where_an_effect_is_identified():
    assert of("identified", (), trial("a", excess=1.0), trial("b", excess=1.05)) == {}
