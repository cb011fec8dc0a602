"""What is said of a resonance followed in the force: beside the curve's peak, and where there is no curve."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.curves import softening_curve

from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.followed_summary import different_peaks
from updamp.workflow.quick_look import ended_early, not_checked, not_followed, peak_sentences, peaks_followed
from updamp.workflow.run_options import RunOptions
from updamp.workflow.summary import curve_entry

TIP = "blade_right.tip.x"


def followed(curve, place, share=1.0, stopped=""):
    """The mode's resonance at the curve's force: a point of the curve, its response `share` as high"""
    none, response = np.zeros(1), share * curve.response[[place], curve.points.index(TIP)]
    return ResonanceCurve(
        curve.mode, TIP, curve.orders, np.array([curve.force]), curve.frequency[[place]], response,
        curve.displacement[[place]], none, none, none, none, np.zeros((1, 4)), np.array([True]),
        np.zeros(1, bool), none, none, none, not stopped, stopped, 0.0,
    )  # fmt: skip


def said(curve, resonance, error=None):
    return different_peaks([curve_entry(curve, TIP, error, followed=resonance)])


def test_a_followed_peak_that_is_not_the_curves_is_said_with_both_numbers():
    curve = softening_curve("OOP", softening=2.0)
    top = int(np.abs(curve.receptance(TIP)).argmax())
    (sentence,) = said(curve, followed(curve, 15))
    assert "0.01000 mm/N at 418.00 Hz" in sentence
    assert "the curve's is the higher one" in sentence
    (sentence,) = said(curve, followed(curve, top, 1.2))
    assert "the one followed is higher" in sentence
    assert said(curve, followed(curve, top)) == []
    assert said(curve, None) == []


@pytest.mark.parametrize(("peak_percent", "count"), [(1.0, 1), (-3.0, 0), (None, 1)])
def test_what_the_curves_stated_error_accounts_for_is_no_other_peak(peak_percent, count):
    curve = softening_curve("OOP")
    top = int(np.abs(curve.receptance(TIP)).argmax())
    error = {"peak_percent": peak_percent, "resonance_hertz": 0.0}
    assert len(said(curve, followed(curve, top, 0.98), error)) == count


def test_as_high_at_another_frequency_is_another_peak():
    curve = softening_curve("OOP")
    top = int(np.abs(curve.receptance(TIP)).argmax())
    elsewhere = replace(followed(curve, top), frequency=np.array([curve.frequency[top] + 5.0]))
    assert len(said(curve, elsewhere)) == 1


def products(resonance):
    """Of a quick look that has left out the curve at 1 N."""
    left = CurveJob(None, "OOP", 1.0, "", Path(), Path(), Path())
    return SimpleNamespace(left=(left,), resonances=(SimpleNamespace(product=resonance),), unknown=())


def test_a_quick_look_says_why_there_is_no_peak():
    curve, options = softening_curve("OOP"), RunOptions("small", Path(), quick=True, resonance=True)
    short = replace(followed(curve, 15, stopped="the resonance stops at 0.9 N"), force=np.array([0.9]))
    assert peak_sentences(peaks_followed(products(short))) == []
    (sentence,) = not_followed(products(short))
    assert "the resonance was not followed so far: the resonance stops at 0.9 N" in sentence
    assert sentence not in not_checked(products(short), options)  # it is a problem of the run, told once
    assert not any("passes it" in one for one in not_checked(products(short), options))
    met = followed(curve, 15)
    assert not_followed(products(met)) == []
    assert "passes it" in not_checked(products(met), options)[0]


def test_a_resonance_that_ends_early_is_said_with_its_reason_where_all_curves_were_traced():
    curve = softening_curve("OOP")
    short = followed(curve, 15, stopped="the resonance stops at 0.9 N")
    (sentence,) = ended_early(SimpleNamespace(left=(), resonances=(SimpleNamespace(product=short),), unknown=()))
    assert sentence.startswith("OOP: ")
    assert sentence.endswith("the resonance stops at 0.9 N")
    assert ended_early(products(short)) == []  # a curve was left out for it, and it is a problem of the run
    whole = followed(curve, 15)
    assert ended_early(SimpleNamespace(left=(), resonances=(SimpleNamespace(product=whole),), unknown=())) == []
