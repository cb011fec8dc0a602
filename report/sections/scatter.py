"""What differs from repeat to repeat, as learnt from the repeats."""

from html import escape

from updamp.comparison.fit.scatter import NOISE
from updamp.report.markup import TIMES, bar, number, table
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>Standard deviations of what changes between repeats, relative to the value itself. They set the scatter
that every misfit in this report is measured in.</p>"""


def render(report: Report) -> Content | None:
    scatter = report.comparison.scatter
    if not scatter:
        return None
    largest = max((value for name, value in scatter.items() if name != NOISE), default=0.0) or 1.0
    rows = [_row(name, value, value / largest) for name, value in scatter.items()]
    return Content(TEXT + table(("Component", "Standard deviation", ""), rows))


def _row(name: str, value: float, share: float) -> tuple[str, str, str]:
    if name == NOISE:  # a factor, not relative to a value
        return escape(name), f"{number(value, 3)} {TIMES} what is stated, or read off the runs", ""
    return escape(name), f"{number(100 * value, 2)} %", bar(share)


SECTION = ReportSection("scatter", "Scatter between repeats", render, "Scatter")
