"""The stress grid's design, and what counts as a false peak."""

from dataclasses import replace

import numpy as np

from updamp.benchmarks.stress import BEYOND, WITHIN, Outcome, design, summary

CASES = design()
FOUND = Outcome(CASES[0], True, "", (250.0, 430.0), 100, 0, 400, 3.0, 0.01, 420.0, {"other end": 0.01})


def test_the_design_has_as_many_as_it_says_within_the_pull_and_beyond():
    assert len(set(CASES)) == WITHIN + BEYOND
    assert sum(case.within_pull for case in CASES) == WITHIN
    assert {case.mode for case in CASES[:12]} == {"OOP", "IP"}
    assert all(0.01 <= case.force_N <= 100 for case in CASES)
    assert all(50 <= case.pull_N <= 5000 for case in CASES)


def test_a_peak_below_what_a_check_finds_is_false():
    assert not FOUND.false_peak
    assert not replace(FOUND, checks={"other end": 0.01005}).false_peak
    assert replace(FOUND, checks={"other end": 0.01, "followed in force": 0.0102}).false_peak
    assert not replace(FOUND, complete=False, checks={"other end": 0.02}).false_peak, "it does not claim a peak"


def test_the_summary_counts_both_kinds_apart():
    within = next(case for case in CASES if case.within_pull)
    beyond = next(case for case in CASES if not case.within_pull)
    outcomes = [
        replace(FOUND, case=within),
        replace(FOUND, case=within, checks={"other end": 0.02}),
        replace(FOUND, case=beyond, complete=False, reason="time", checks={}, peak_mm_per_N=np.nan),
    ]
    found = summary(outcomes)
    assert found["within_pull"] == {"curves": 2, "complete": 2, "checked": 2, "false_peaks": 1}
    assert found["beyond_pull"] == {"curves": 1, "complete": 0, "checked": 0, "false_peaks": 0}
    assert [entry["reason"] for entry in found["not_complete"]] == ["time"]
    assert len(found["false_peaks"]) == 1
