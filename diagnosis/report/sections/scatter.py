"""What differs from repeat to repeat, as learnt from the repeats."""

from html import escape

from updamp.diagnosis.report.markup import bar, number, table
from updamp.diagnosis.report.section import Content, Report, Section

TEXT = """<p>Standard deviations of what changes between repeats, relative to the value itself. They set the scatter
that every misfit in this report is measured in.</p>"""


def render(report: Report) -> Content | None:
    scatter = report.comparison.scatter
    if not scatter:
        return None
    largest = max(scatter.values()) or 1.0
    rows = [(escape(name), f"{number(100 * value, 2)} %", bar(value / largest)) for name, value in scatter.items()]
    return Content(TEXT + table(("Component", "Standard deviation", ""), rows))


SECTION = Section("scatter", "Scatter between repeats", render, "Scatter")
