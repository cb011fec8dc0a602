"""What to measure next, to tell apart what is left."""

import math
from html import escape

from updamp.diagnosis.verdict import NextMeasurement
from updamp.report.markup import MISSING, number, table
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>Separation: how far the remaining explanations lie apart in what this measurement would show, in standard
deviations of the scatter. Most separation per hour of testing first.</p>"""
HEAD = ("Measurement", "Tells apart", "Separation", "Hours", "Separation per hour")


def render(report: Report) -> Content | None:
    if report.verdict is None or not report.verdict.next_measurement:
        return None
    return Content(TEXT + table(HEAD, [_row(each) for each in report.verdict.next_measurement], numbers_from=2))


def _row(each: NextMeasurement) -> tuple[str, ...]:
    rate = each.separation / each.hours if each.hours > 0 else math.nan
    names = escape(", ".join(each.effects)) or MISSING
    return escape(each.sentence), names, number(each.separation, 3), number(each.hours, 2), number(rate, 3)


SECTION = ReportSection("next", "Next measurement", render, "Next")
