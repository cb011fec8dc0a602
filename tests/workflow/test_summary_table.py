"""The table of curves in a terminal of 80 columns, the narrowest that there is."""

from io import StringIO

from rich.console import Console

from updamp.workflow.summary import curves_table

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
