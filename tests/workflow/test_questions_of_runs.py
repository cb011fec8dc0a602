"""What is asked of a measurement's runs before anything is fitted to them."""

from dataclasses import replace
from math import nan

import pytest
from support.jumping_beam import Joint, Mode, measured

from updamp.workflow.measured_against_model import another_pull, unknown_modes

RUNS = measured((Mode(80.0, 0.003, 2.0),), Joint(), (79.5, 80.5), (1.0,), True, 12, 0.01, 1)


def test_a_pull_that_is_not_the_rig_file_s_is_asked_about():
    assert another_pull(replace(RUNS, pull=960.0), 960.0) == []
    assert another_pull(replace(RUNS, pull=nan), 960.0) == []
    (asked,) = another_pull(replace(RUNS, pull=500.0), 960.0)
    assert "damper_load = 500 N" in asked
    assert "load.pull = 960 N" in asked


@pytest.mark.parametrize(("modes", "asked"), [(("first", "second"), 0), (("fist", "second"), 1), (("bend",), 1)])
def test_a_mode_that_the_rig_is_not_given_by_is_asked_about(modes, asked):
    questions = unknown_modes(RUNS, modes)
    assert len(questions) == asked
    if "fist" in modes:
        assert "did you mean fist?" in questions[0]


def test_spaces_in_a_mode_s_name_are_underscores_in_the_rig_file():
    runs = tuple(replace(run, mode="first bending") for run in RUNS.runs)
    assert unknown_modes(replace(RUNS, runs=runs), ("first_bending",)) == []
