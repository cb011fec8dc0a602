"""The report as a file."""

from collections.abc import Mapping
from pathlib import Path

from updamp.diagnosis.comparison import Comparison
from updamp.diagnosis.report.page import build_page
from updamp.diagnosis.report.registry import SECTIONS
from updamp.diagnosis.report.section import Report
from updamp.diagnosis.verdict import Verdict

NO_PICTURES: Mapping[str, bytes] = {}


def write_report(
    comparison: Comparison, path: Path, pictures: Mapping[str, bytes] = NO_PICTURES, verdict: Verdict | None = None
) -> None:
    """One self-contained HTML file.

    pictures: caption -> PNG
    verdict: of the diagnosis; its sections are left out without one
    raises: ValueError for a picture that is no PNG, naming it; OSError where the file cannot be written
    """
    path.write_text(build_page(Report(comparison, verdict, pictures), SECTIONS), encoding="utf-8")
