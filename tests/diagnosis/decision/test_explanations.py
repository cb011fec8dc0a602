"""Probabilities of the models that were fitted, from evidence made up."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.diagnosis.decision.explanations import explanations, in_words
from updamp.diagnosis.evidence import Evidence, Trial

AS_ONE, INDEPENDENT = 10.0, 100.0
PENALTY = float(np.log(INDEPENDENT))
ONE = Trial(("slip",), 1.2, AS_ONE * (PENALTY + 6.0), 6.0, 1.1, "", True)
EQUAL = replace(ONE, effects=("spring",), excess=1.1)
TWO = replace(ONE, effects=("slip", "spring"), drop=AS_ONE * (2 * PENALTY + 2.0), parameters=2)
EVIDENCE = Evidence(9.0, 2.5, 1.0, (), (ONE, EQUAL), (TWO,), (), independent=INDEPENDENT, as_one=AS_ONE)


def test_probabilities_are_the_criterion_s_weights() -> None:
    found = {e.effects: e.probability for e in explanations(EVIDENCE)}
    assert sum(found.values()) == pytest.approx(1.0)
    assert found["slip",] == found["spring",]
    assert found["slip",] / found[()] == pytest.approx(np.exp(3.0))
    assert found["slip", "spring"] / found[()] == pytest.approx(np.exp(1.0))


def test_the_likeliest_come_first_with_what_they_leave_and_the_better_fit_of_two_alike() -> None:
    found = explanations(EVIDENCE)
    assert [e.effects for e in found] == [("spring",), ("slip",), ("slip", "spring"), ()]
    assert (found[-1].misfit, found[-1].held_out) == (3.0, 2.5)


def test_fits_that_were_not_left_to_settle_and_gains_beyond_all_numbers_do_no_harm() -> None:
    huge, short = replace(ONE, drop=1e6), replace(EQUAL, full=False)
    found = explanations(replace(EVIDENCE, trials=(huge, short), combined=()))
    assert [(e.effects, e.probability) for e in found] == [(("slip",), 1.0), ((), 0.0)]


WORDS = {1.0: "virtually certain", 0.95: "very likely", 0.5: "about as likely as not", 0.0: "exceptionally unlikely"}


@pytest.mark.parametrize(("probability", "words"), WORDS.items())
def test_words(probability: float, words: str) -> None:
    assert in_words(probability) == words
