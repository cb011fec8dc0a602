"""The table of curves in a terminal of 80 columns, the narrowest that there is."""

import json
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from support.curves import POINTS, softening_curve

from updamp.workflow.summary import curve_entry
from updamp.workflow.summary_tables import curves_table

ERROR = {"peak_percent": -17.985, "resonance_hertz": -0.00082, "complete": True, "orders": [0, 1, 2, 3, 4, 5, 6, 7]}
ENTRY = {
    "mode": "OOP",
    "force_N": 0.0961,
    "points": 1234,
    "peak_receptance_mm_per_N": 0.01053,
    "peak_frequency_Hz": 437.26,
    "numerical_error": ERROR,
    "jumps_up_Hz": [426.8],
    "jumps_down_Hz": [426.72, 397.12],
    "seconds": 234.0,
    "problem": "it stopped",
    "stability": {"peak": "unstable"},
    "marching": {"verdict": "leaves"},
}


def test_no_number_and_no_word_is_cut_off():
    console = Console(width=80, record=True, file=StringIO())
    console.print(curves_table([ENTRY]))
    text = console.export_text()
    assert "…" not in text
    words = text.split()
    for word in ("0.0961", "0.01053", "437.26", "-18", "-0.001", "426.80", "426.72", "397.12", "1234", "234"):
        assert word in words
    for word in ("complete,", "unstable,", "leaves", "points"):
        assert word in words


@pytest.mark.parametrize(
    ("orders", "said"),
    [
        ([0, 1, 2, 3], "error: what harmonics 0, 1, 2, 3 change, of the peak's height and frequency"),
        ([1, 3, 5], "error: what harmonics 1, 3, 5 change, of the peak's height and frequency; what the mean position "
         "(harmonic 0) changes is not in it"),
        ([], "error: what further harmonics change, of the peak's height and frequency"),
    ],
)  # fmt: skip
def test_it_is_said_what_the_error_is_of(orders, said):
    assert curves_table([{**ENTRY, "numerical_error": {**ERROR, "orders": orders}}]).caption == said


@pytest.mark.parametrize("work", [0.0, np.nan])
def test_shares_of_work_are_null_where_a_point_takes_none(work):
    curve = softening_curve()
    nothing = np.full(len(curve), work)
    still = replace(curve, work_in=nothing, friction_loss=nothing, material_loss=nothing)
    entry = curve_entry(still, POINTS[1])
    assert entry["energy_balance_error"] is None
    assert entry["friction_share_of_loss_at_peak"] is None
    assert "NaN" not in json.dumps(entry)
    assert curve_entry(curve, POINTS[1])["energy_balance_error"] == pytest.approx(0, abs=1e-12)
    assert curve_entry(curve, POINTS[1])["friction_share_of_loss_at_peak"] == pytest.approx(0.75)
