"""What force the model lacks, as stiffness and damping against amplitude, mode by mode."""

from html import escape
from typing import Any

import numpy as np

from updamp.diagnosis.verdict import MissingForce
from updamp.report.markup import LEVELS, DrawnUnits, drawn_units, figure_element, level_name
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>The measured motion put into the model leaves a force over. Here it is per displacement and per velocity:
constant stiffness is a spring, one that grows with the square of amplitude a cubic spring; constant damping is viscous,
damping that grows with amplitude quadratic, damping that falls with 1/amplitude dry friction. Bars: 95 % interval, and
so are the numbers, of this reading alone: it is made beside the calibration without any effect, which may have taken up
a part of what is missing, and refers the force to the point that is named. What a fit of an effect found is listed with
the effects, at the point where that one acts.</p>"""
PANELS = (("stiffness", 0.0, 0.43), ("damping", 0.57, 1.0))


def render(report: Report) -> Content | None:
    if report.verdict is None or not report.verdict.missing_forces:
        return None
    forces = report.verdict.missing_forces
    readings = "".join(f"<li><strong>{escape(f.mode)}</strong>: {escape(f.reading)}</li>" for f in forces if f.reading)
    plot = figure_element(
        "missing-force",
        "Missing stiffness and missing damping against displacement amplitude, one colour a mode. "
        + " ".join(f"{force.mode}: {force.reading}." for force in forces),
    )
    unit, drawn = report.comparison.level_unit, drawn_units(report.comparison)
    traces = [trace for k, force in enumerate(forces) for trace in _traces(force, LEVELS[k % len(LEVELS)], unit, drawn)]
    return Content(f"{TEXT}<ul>{readings}</ul>{plot}", {"missing-force": {"data": traces, "layout": _layout(drawn)}})


def _traces(force: MissingForce, colour: str, level_unit: str, drawn: DrawnUnits) -> list[dict[str, Any]]:
    order, (across, factor) = np.argsort(force.amplitude), drawn.displacement
    columns = (
        (force.stiffness, force.stiffness_deviation, "", drawn.stiffness),
        (force.damping, force.damping_deviation, "2", drawn.damping),
    )
    return [
        {
            "type": "scatter", "mode": "markers", "x": factor * force.amplitude[order], "y": value[order],
            "error_y": {"type": "data", "array": 1.96 * deviation[order], "thickness": 1, "width": 3},
            "xaxis": f"x{axis}", "yaxis": f"y{axis}", "name": force.mode, "legendgroup": force.mode,
            "showlegend": not axis, "marker": {"color": colour, "size": 7},
            "customdata": [level_name(level, level_unit) for level in force.level[order]],
            "hovertemplate": f"{force.mode}, %{{customdata}}<br>%{{x:.3g}} {across}: %{{y:.4g}} {unit}<extra></extra>",
        }
        for value, deviation, axis, unit in columns
    ]  # fmt: skip


def _layout(drawn: DrawnUnits) -> dict[str, Any]:
    across = {"text": f"displacement amplitude [{drawn.displacement[0]}]"}
    layout: dict[str, Any] = {"legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"}}
    for axis, unit, (what, *domain) in zip(("", "2"), (drawn.stiffness, drawn.damping), PANELS, strict=True):
        layout[f"xaxis{axis}"] = {
            "title": across, "type": "log", "tickformat": "~g", "domain": domain, "anchor": f"y{axis}",
        }  # fmt: skip
        layout[f"yaxis{axis}"] = {
            "title": {"text": f"missing {what} [{unit}]"}, "anchor": f"x{axis}",
            "zeroline": True, "zerolinecolor": "#8a8f98",
        }  # fmt: skip
    return layout


SECTION = ReportSection("missing-force", "The missing force", render, "Missing force")
