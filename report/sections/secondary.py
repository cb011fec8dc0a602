"""Correlation criteria of model updating, for those used to them."""

from html import escape

from updamp.comparison.comparison import CurvePair
from updamp.report.markup import level_name, number, table
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>After calibration; 1 is perfect. FRAC: frequency response assurance criterion; CSAC and CSF: cross
signature assurance criterion and scale factor. They weigh large amplitudes most and know nothing of scatter, so no
verdict rests on them.</p>"""
HEAD = ("Run", "Mode", "Channel", "Sweep", "Level", "FRAC", "CSAC", "CSF")


def render(report: Report) -> Content | None:
    curves = report.comparison.curves
    if not curves:
        return None
    inside = table(HEAD, [_row(curve, report.comparison.level_unit) for curve in curves], numbers_from=4)
    return Content(f"{TEXT}<details><summary>{len(curves)} curves</summary>{inside}</details>")


def _row(curve: CurvePair, unit: str) -> tuple[str, ...]:
    direction = "up" if curve.upwards else "down"
    numbers = tuple(number(value, 3) for value in (curve.frac, curve.csac, curve.csf))
    words = escape(curve.run), escape(curve.mode), escape(curve.channel), direction
    return *words, level_name(curve.level, unit), *numbers


SECTION = ReportSection("secondary", "Secondary numbers", render, "FRAC, CSAC, CSF")
