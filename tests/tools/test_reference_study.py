"""The table of findings in the documents."""

from updamp.tools.reference_study import table

FINDING = {"number": 3, "paper": "IP softens", "updamp": "424 to 402 Hz", "met": True}
CONTENT = {
    "mesh": "full", "written": "2026-11-23T01:30:00+00:00", "seconds_of_curves": 303.6, "findings_met": "1 of 3",
    "curves": [{"complete": True}, {"complete": False}],
    "findings": [FINDING, {**FINDING, "met": False}, {**FINDING, "met": None}],
}  # fmt: skip


def test_each_finding_is_a_line_and_what_is_not_complete_is_told():
    lines = table(CONTENT).splitlines()
    assert "2 curves, 1 of them complete" in lines[0]
    assert [line.split("|")[-2].strip() for line in lines[-3:]] == ["met", "**not met**", "not known"]
