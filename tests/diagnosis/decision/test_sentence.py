"""No sentence says what the evidence beside it does not."""

from dataclasses import replace

import pytest

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.decision.sentence import Wording, sentence
from updamp.diagnosis.evidence import EffectScore, Evidence, Trial

WORDS = Wording({"slip": "contacts slip", "spring": "a spring is there"}, "the scatter", "runs that the fit never saw")
SLIP = Trial(("slip",), 1.05, 9000.0, 890.0, 1.1, "", True, unseen=1.1)
EVIDENCE = Evidence(
    excess=9.0,
    held_out=3.0,
    repeatability=1.0,
    tested=(EffectScore("slip", 90.0, 0.8, 8100.0, 0.6, 200.0),),
    trials=(SLIP,),
    combined=(),
    alike=(),
    independent=192.0,
    unseen=9.0,
    unseen_independent=72.0,
    as_one=10.0,
)


def said(**changes) -> str:
    evidence = replace(EVIDENCE, **changes)
    return sentence(decide(evidence, Criteria()), evidence, Criteria(), WORDS)


def test_what_is_named_is_told_with_its_fall() -> None:
    assert said() == (
        "contacts slip (slip): the error falls from 3.0 to 1.02 times the scatter, on runs that the fit never saw "
        "from 3.0 to 1.10"
    )


def test_it_is_told_that_nothing_was_held_out() -> None:
    unseen = {"held_out": float("nan"), "unseen": float("nan")}
    fall = "the error falls from 3.0 to 1.02 times the scatter; no run was held out"
    assert said(**unseen, trials=(replace(SLIP, **unseen),)) == f"contacts slip (slip): {fall}"


def test_what_cannot_be_told_apart_is_told_with_what_is_missing_whichever_it_is() -> None:
    pairs = tuple(replace(SLIP, effects=("slip", name), excess=1.0 + i / 100) for i, name in enumerate(("a", "b")))
    fall = "and these data do not tell which: the error falls from 3.0 to 1.00 times the scatter, on"
    assert said(trials=(), combined=pairs).startswith(
        f"contacts slip (slip), and one of a, b is missing beside, {fall}"
    )
    singles = (replace(SLIP, excess=1.0), replace(SLIP, effects=("spring",), excess=1.05))
    assert said(trials=singles).startswith(f"one of slip, spring is missing, {fall}")
    two = (replace(SLIP, effects=("slip", "a", "b")), replace(SLIP, effects=("slip", "c", "d")))
    assert "and 2 of a, b, c, d are missing beside" in said(trials=(), combined=two)


def test_an_adequate_model_is_told_without_a_word_on_effects_that_predict_better() -> None:
    """One predicted the held-out runs better, and the data do not ask for it."""
    better = replace(SLIP, excess=0.9, delta_bic=3.0, held_out=0.5, unseen=0.3)
    assert said(excess=1.1, held_out=0.9, unseen=0.8, trials=(better,)) == (
        "nothing is missing that these data show: the calibrated model is off by 1.05 times the scatter, on runs that "
        "the fit never saw by 0.90"
    )


def test_what_the_runs_of_the_fit_do_not_show_is_told_with_what_to_do() -> None:
    assert said(excess=0.93, held_out=3.2, unseen=5.3, trials=()) == (
        "the calibrated model explains the runs of the fit alone; it is off by 0.96 times the scatter, on runs that "
        "the fit never saw by 3.20. What is missing shows in these: hold out other runs (--hold-out), so that the fit "
        "sees it"
    )


def test_what_is_off_in_held_out_runs_alone_is_told_beside_an_adequate_model() -> None:
    """Their misfit is one that chance makes in one test of twenty at most, or nothing is said."""
    off = {"held_out": 8.1, "unseen_independent": 32.0, "unseen_farthest": "the gain of the sensor at tip.x"}
    looked_at = "on runs that the fit never saw by 8.10, as with the gain of the sensor at tip.x 9 deviations off: look"
    assert looked_at in said(trials=(), excess=1.0, unseen=1.8, unseen_deviations=-9.2, **off)
    assert "deviations off" not in said(trials=(), excess=1.0, unseen=1.1, unseen_deviations=-9.2, **off)
    assert "deviations off" not in said(trials=(), excess=1.0, unseen=1.8, unseen_deviations=2.0, **off)


def test_an_adequate_model_is_told_with_what_the_data_ask_for_and_why_it_is_not_named() -> None:
    found = said(excess=1.2, held_out=0.9, unseen=0.8, trials=(replace(SLIP, at_bound="slip.size"),))
    why = "slip.size would have to be beyond what is physical"
    assert found.endswith(f"; slip leaves 1.0 times (1.1 on held-out runs), but {why}")


@pytest.mark.parametrize(
    ("against", "why"),
    [
        ({"at_bound": "slip.size"}, "slip.size would have to be beyond what is physical"),
        ({"held_out": 3.1}, "runs that the fit never saw are not predicted better"),
    ],
)
def test_an_unknown_does_not_say_that_nothing_explains_what_something_does(against, why) -> None:
    found = said(trials=(replace(SLIP, **against),))
    assert "no effect explains it" not in found
    assert found.endswith(f", but {why}")


def test_an_unknown_says_that_nothing_explains_it_where_nothing_does() -> None:
    found = said(trials=(replace(SLIP, excess=4.0, unseen=4.0, held_out=2.0, farthest="preload", deviations=5.2),))
    assert found == (
        "something is missing that the catalogue does not have: the model is off by 3.0 times the scatter, and no "
        "effect explains it. Closest: slip leaves 2.0 times (2.0 on held-out runs) with preload 5.2 deviations from "
        "what is stated"
    )


def test_with_nothing_held_out_nothing_is_said_of_it() -> None:
    nan = float("nan")
    alone = replace(SLIP, held_out=nan, unseen=nan)
    found = said(excess=1.1, held_out=nan, unseen=nan, unseen_independent=0.0, trials=(replace(alone, delta_bic=1.0),))
    assert found.endswith("1.05 times the scatter; no run was held out")


def test_what_an_effect_leaves_beyond_chance_is_told_with_its_name() -> None:
    """A sensor that compressed was called drag, which left 1.4 times the scatter."""
    doubtful = replace(SLIP, excess=1.2)
    assert said(trials=(doubtful,)).endswith(
        "to 1.10; chance leaves as much in one test of 20 at most: it may not be all, or a like law"
    )
