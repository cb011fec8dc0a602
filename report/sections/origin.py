"""What was assumed, and what the comparison was made from."""

from html import escape

from updamp.report.markup import table
from updamp.report.section import Content, Report, ReportSection


def assumptions(report: Report) -> Content | None:
    items = "".join(f"<li>{escape(each)}</li>" for each in report.comparison.assumptions)
    return Content(f"<ul>{items}</ul>") if items else None


def provenance(report: Report) -> Content | None:
    stated = {**report.comparison.provenance, **(report.verdict.provenance if report.verdict else {})}
    rows = [(escape(name), f"<code>{escape(value)}</code>") for name, value in stated.items()]
    return Content(table(("What", "From"), rows, numbers_from=2)) if rows else None


ASSUMPTIONS = ReportSection("assumptions", "Assumptions", assumptions)
PROVENANCE = ReportSection("provenance", "Provenance", provenance)
