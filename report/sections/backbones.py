"""Resonance against amplitude: frequency, loss factor and peak receptance, measured and calibrated model."""

from typing import Any

from updamp.comparison.comparison import Backbone
from updamp.report.markup import DrawnUnits, drawn_units, figure_element
from updamp.report.section import Content, Report, ReportSection


def render(report: Report) -> Content | None:
    measured, model = report.comparison.measured_backbones, report.comparison.model_backbones
    if not measured and not model:
        return None
    html = "<p>Shown for the mode and channel chosen above.</p>" if report.comparison.curves else ""
    html += figure_element(
        "backbones",
        "Resonance frequency and equivalent loss factor against the displacement amplitude, and peak receptance "
        "against force: measured as points, calibrated model as a line.",
        "Points: measured, one symbol a repeat; line: calibrated model.",
        380,
    )
    both = {"measured": measured, "model": model}
    data = {name: [_columns(each, drawn_units(report.comparison)) for each in some] for name, some in both.items()}
    return Content(html, data=data, scripts=("selection.js", "backbones.js"))


def _columns(backbone: Backbone, drawn: DrawnUnits) -> dict[str, Any]:
    return {
        "mode": backbone.mode,
        "channel": backbone.channel,
        "level": backbone.level,
        "repeat": backbone.repeat,
        "amplitude": drawn.displacement[1] * backbone.amplitude,
        "frequency": backbone.frequency,
        "damping": backbone.damping,
        "receptance": drawn.receptance[1] * backbone.receptance,
    }


SECTION = ReportSection("backbones", "Resonance against amplitude", render, "Resonance")
