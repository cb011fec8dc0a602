"""What is said of branches beside a curve."""

from dataclasses import replace

import numpy as np
from support.curves import softening_curve

from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.branch_stability import State
from updamp.hbm.stability.detached_branches import DetachedBranches
from updamp.workflow import store
from updamp.workflow.detached_jobs import has_more, resonances_at
from updamp.workflow.detached_summary import coexisting
from updamp.workflow.summary import curve_entry
from updamp.workflow.summary_tables import curves_table

TIP = "blade_right.tip.x"


def with_share(curve, share, state, closed=True):
    """A curve's entry with a branch beside it that is `share` as high"""
    branch = replace(curve, response=share * curve.response, complete=closed, stopped="" if closed else "it stopped")
    found = DetachedBranches(curve.mode, curve.force, (branch,), np.array([int(state)]), ("",), 0.1)
    return curve_entry(curve, TIP, detached=found)


def test_a_loop_is_listed_with_its_peak():
    curve = softening_curve(softening=2.0)
    entry = with_share(curve, 0.5, State.UNSTABLE)
    (one,) = entry["detached"]
    assert one["closed"]
    assert one["peak_stability"] == "unstable"
    assert one["peak_receptance_mm_per_N"] == 0.5 * entry["peak_receptance_mm_per_N"]
    assert len(one["resonances"]) == 1
    (sentence,) = coexisting([entry])
    assert "a closed loop" in sentence
    assert "unstable" in sentence
    assert "higher" not in sentence
    assert curve_entry(curve, TIP)["detached"] == []


def test_one_that_is_higher_than_the_peak_is_said_to_be():
    entry = with_share(softening_curve(softening=2.0), 1.2, State.UNKNOWN, closed=False)
    (sentence,) = coexisting([entry])
    assert "followed in part" in sentence
    assert "not known to be stable" in sentence
    assert "higher than the curve's peak of 0.01000 mm/N" in sentence
    cells = [cell for column in curves_table([entry]).columns for cell in column.cells]
    assert any("higher beside it" in str(cell) for cell in cells)


def test_they_are_stored_with_their_curve(tmp_path):
    curve = softening_curve()
    branch = replace(curve, response=2 * curve.response)
    store.write(tmp_path / "curve.h5", replace(curve, detached=(branch,)), store.Stamp("key"))
    read = store.read(tmp_path / "curve.h5", type(curve))
    (again,) = read.detached
    np.testing.assert_array_equal(again.response, branch.response)
    assert again.detached == ()


def test_resonances_that_are_not_on_the_curve_are_looked_at_once_it_is_at_their_force():
    curve = softening_curve(force=2.0)
    none, there = np.zeros(3), np.array([20, 60, 100])
    followed = ResonanceCurve(
        curve.mode, TIP, curve.orders, np.array([2.0, 2.0, 1.0]), curve.frequency[there], none,
        np.stack([curve.displacement[20], 3 * curve.displacement[60], curve.displacement[100]]), none, none, none, none,
        np.zeros((3, 4)), np.array([True, True, True]), np.zeros(3, bool), none, none, none, True, "", 0.0,
    )  # fmt: skip
    assert len(resonances_at(curve, followed)) == 2, "the third is at another force"
    assert has_more(curve, followed, (410.0, 430.0))
    on_it = replace(followed, asked_for=np.array([True, False, True]))
    assert not has_more(curve, on_it, (410.0, 430.0))
    assert not has_more(curve, None, (410.0, 430.0))
