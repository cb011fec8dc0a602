"""Stated values beside the model's."""

import math
from html import escape

from updamp.comparison.comparison import FeatureComparison
from updamp.report.markup import MISSING, level_name, number, paragraph, percent, table
from updamp.report.section import Content, Report, ReportSection

HEAD = ("Quantity", "Mode", "Force", "Measured", "Model", "Model against measured")

NOT_JUDGED = "Of the rig as its file states it, before any calibration; the verdict is of the curves alone."


def render(report: Report) -> Content | None:
    features = report.comparison.features
    if not features:
        return None
    judged = paragraph(NOT_JUDGED) if report.comparison.curves else ""
    return Content(judged + table(HEAD, [_row(each) for each in features], numbers_from=2))


def _row(each: FeatureComparison) -> tuple[str, ...]:
    force = MISSING if math.isnan(each.force) else level_name(each.force)
    name = each.quantity.replace("_", " ")
    return escape(name), escape(each.mode), force, _stated(each), _value(each, each.model), _judgement(each)


def _value(each: FeatureComparison, value: float) -> str:
    """A frequency in Hz, a relative shift in per cent; other quantities as they are"""
    if each.quantity.endswith("_shift"):
        return percent(value)
    unit = " Hz" if each.quantity.endswith("frequency") and not math.isnan(value) else ""
    return number(value, 5) + unit


def _stated(each: FeatureComparison) -> str:
    bounds = math.isfinite(each.lower), math.isfinite(each.upper)
    if math.isfinite(each.measured):
        return _value(each, each.measured)
    if all(bounds):
        return f"{_value(each, each.lower)} … {_value(each, each.upper)}"
    if any(bounds):
        return f"above {_value(each, each.lower)}" if bounds[0] else f"below {_value(each, each.upper)}"
    return MISSING


def _judgement(each: FeatureComparison) -> str:
    if math.isfinite(each.relative):
        return percent(each.relative)
    if math.isnan(each.model):
        return MISSING
    if each.model < each.lower:
        return "below the stated range"
    return "above the stated range" if each.model > each.upper else "within the stated range"


SECTION = ReportSection("features", "Stated features", render, "Features")
