"""Derivatives of a fit to targets beside a bound, where designs on one side are not known."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from updamp.design.goals import Objective, Target
from updamp.design.methods.least_squares import _Misfit
from updamp.design.methods.method import Problem
from updamp.design.records import DONE, FAILED, Record
from updamp.design.variables import Variable

SLOPE, STEP = 5.0, 0.01


def misfit(known_above: float) -> _Misfit:
    """Of a response 5 x, x from 0 to 1, against a target of 0; it is not known for x > known_above."""

    def evaluate(designs: Sequence[Mapping[str, float]], _expected: int | None = None) -> list[Record]:
        records = []
        for one in designs:
            known = one["x"] <= known_above
            outcome, value = (DONE, SLOPE * one["x"]) if known else (FAILED, None)
            records.append(Record("", "", one, outcome, {"y": value}, "" if known else "too long"))
        return records

    goal = Target(target=0.0, tolerance=1.0)
    problem = Problem("s", (Variable("x", "x", "", 0.0, 1.0, 0.5),), ("y",), (Objective("y", goal),), (), Path())
    return _Misfit(problem, evaluate, STEP)


@pytest.mark.parametrize(("x", "known_above"), [(0.5, 1.0), (0.5, 0.5), (1.0, 1.0), (0.004, 0.004)])
def test_the_derivative_is_that_of_the_step_that_was_taken(x: float, known_above: float) -> None:
    assert misfit(known_above).jacobian(np.array([x])) == pytest.approx(np.array([[SLOPE]]))


def test_at_a_bound_with_nothing_known_beside_it_there_is_no_derivative() -> None:
    with pytest.raises(ValueError, match=r"not known on either side .* too long; narrow the bounds"):
        misfit(0.0).jacobian(np.array([0.0]))
