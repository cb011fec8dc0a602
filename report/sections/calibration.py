"""Nuisance parameters before and after calibration."""

import math
from html import escape

from updamp.comparison.comparison import Calibrated
from updamp.report.markup import MISSING, number, percent, table, with_unit
from updamp.report.section import Content, Report, ReportSection

FAR = 2.0  # prior standard deviations, from where on a calibrated value deserves a word


def render(report: Report) -> Content | None:
    calibration = report.comparison.calibration
    if not calibration:
        return None
    head = ("Parameter", "Rig file", "Calibrated", "95 % interval", "Change", "Change / prior deviation")
    html = table(head, [_row(each) for each in calibration])
    far = [each.name for each in calibration if abs(_in_deviations(each)) > FAR]
    if far:
        html += (
            f'<p class="note">Further from the rig file than {FAR:g} standard deviations of the prior: '
            f"{escape(', '.join(far))}. A calibration that has to go so far often makes up for something that the "
            "model lacks.</p>"
        )
    return Content(html)


def _row(each: Calibrated) -> tuple[str, ...]:
    change = (each.after - each.before) / abs(each.before) if each.before else math.nan
    moved = _in_deviations(each)
    text = number(moved, 2) if math.isfinite(moved) else MISSING
    return (
        escape(each.name),
        with_unit(each.before, each.unit),
        with_unit(each.after, each.unit),
        f"{number(each.lower)} … {with_unit(each.upper, each.unit)}",
        percent(change),
        f'<strong class="far">{text}</strong>' if abs(moved) > FAR else text,
    )


def _in_deviations(each: Calibrated) -> float:
    deviation = abs(each.before) * each.prior_deviation
    return (each.after - each.before) / deviation if deviation > 0 else math.nan


SECTION = ReportSection("calibration", "Calibration", render)
