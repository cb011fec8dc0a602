"""Nuisance parameters before and after calibration."""

import math
from html import escape

from updamp.comparison.comparison import FAR, Calibrated, Comparison
from updamp.report.markup import MISSING, number, percent, table, with_unit
from updamp.report.section import Content, Report, ReportSection

MAKES_UP = "A calibration that has to go so far often makes up for something that the model lacks"
_HEAD = ("Parameter", "Rig file", "Calibrated", "95 % interval", "Change", "Change / prior deviation")


def render(report: Report) -> Content | None:
    calibration = report.comparison.calibration
    if not calibration:
        return None
    html = table(_HEAD, [_row(each) for each in calibration])
    if of_modes := report.comparison.calibrated_modes:
        html += (
            "<p>Of each mode, the factor on all modes and the one on it alone together: what the test tells, often far "
            "better than each of the two.</p>"
        )
        html += table(_HEAD, [_row(each) for each in of_modes])
    far = [each.name for each in _as_told(report.comparison) if each.far]
    if far:
        html += (
            f'<p class="note">Further from the rig file than {FAR:g} standard deviations of the prior: '
            f"{escape(', '.join(far))}. {MAKES_UP}.</p>"
        )
    return Content(html + _with_effects(report))


def _with_effects(report: Report) -> str:
    """What else is calibrated once a verdict has named what is missing: the model without that bends to make up for
    it, and its intervals need not hold what is true."""
    verdict = report.verdict
    if verdict is None or not verdict.effects or not verdict.calibration:
        return ""
    text = f"<p>All above is of the model without effects. Together with {escape(', '.join(verdict.effects))}:</p>"
    return text + table(_HEAD, [_row(each) for each in verdict.calibration])


def far_calibrated(comparison: Comparison) -> str:
    """A sentence for the terminal, "" where nothing was calibrated far."""
    far = [
        f"{each.name} to {each.after:.3g} times the rig file's, {abs(each.deviations):.1f} deviations of how well it "
        "is known"
        for each in _as_told(comparison)
        if each.far
    ]
    return f"{'; '.join(far)}. {MAKES_UP}." if far else ""


def _as_told(comparison: Comparison) -> tuple[Calibrated, ...]:
    """Of several modes what the test tells: a factor on all of them and one that takes it back of one are both far,
    and that mode is where it was."""
    return comparison.calibrated_modes or comparison.calibration


def _row(each: Calibrated) -> tuple[str, ...]:
    change = (each.after - each.before) / abs(each.before) if each.before else math.nan
    moved = each.deviations
    text = number(moved, 2) if math.isfinite(moved) else MISSING
    return (
        escape(each.name),
        with_unit(each.before, each.unit),
        with_unit(each.after, each.unit),
        f"{number(each.lower)} … {with_unit(each.upper, each.unit)}",
        percent(change),
        f'<strong class="far">{text}</strong>' if each.far else text,
    )


SECTION = ReportSection("calibration", "Calibration", render)
