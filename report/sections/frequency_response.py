"""Measured and computed receptance over each other, one curve or all force levels."""

from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Comparison, CurvePair, MeasuredCurve, ModelCurve
from updamp.report.markup import drawn_units, figure_element
from updamp.report.phases import CurvePhases, phases_of
from updamp.report.section import Content, Report, ReportSection

Floats = NDArray[np.float64]

CONTROLS = """<form class="controls" id="curve-controls" autocomplete="off">
<label>Mode <select id="select-mode"></select></label>
<label>Level <select id="select-level"></select></label>
<label>Channel <select id="select-channel"></select></label>
<label>Sweep <select id="select-sweep"></select></label>
<label class="check"><input type="checkbox" id="logarithmic"> logarithmic</label>
<label class="check"><input type="checkbox" id="show-before" checked> model before calibration</label>
</form>
<p class="selection" id="selection" role="status"></p>"""


def render(report: Report) -> Content | None:
    curves = report.comparison.curves
    if not curves:
        return None
    plot = figure_element(
        "response",
        "Receptance against frequency, amplitude above and phase below: measured repeats as points with their "
        "95 % band, the model before calibration dashed, calibrated solid, parts no slow sweep visits dotted.",
        "Points: measured, one symbol a repeat; grey: 95 % of what a repeat gives. Blue: calibrated model; thin "
        "dashed: before calibration; dotted: what a slow sweep in this direction jumps over. "
        '<span class="screen">Zoom by dragging, double click for all.</span>',
        500,
    )
    _, factor = drawn_units(report.comparison).receptance
    data = {
        "curves": [_curve_data(*each, factor) for each in zip(curves, phases_of(curves), strict=True)],
        "start": _worst(report.comparison),
    }
    return Content(CONTROLS + plot, data=data, scripts=("selection.js", "response.js"))


def _worst(comparison: Comparison) -> int:
    """Which curve the page opens with: the one of the largest mean square residual."""
    sizes: dict[tuple[str, str], list[float]] = defaultdict(list)
    for residual in comparison.residuals:
        sizes[residual.run, residual.channel].append(residual.size)
    mean = [float(np.mean(np.square(sizes.get((c.run, c.channel), [0.0])))) for c in comparison.curves]
    return int(np.argmax(mean))


def _curve_data(curve: CurvePair, phases: CurvePhases, factor: float) -> dict[str, Any]:
    band = curve.band
    return {
        "run": curve.run,
        "mode": curve.mode,
        "level": curve.level,
        "up": curve.upwards,
        "channel": curve.channel,
        "measured": [
            {"repeat": each.repeat, **_polar(each, phase, factor)}
            for each, phase in zip(curve.measured, phases.measured, strict=True)
        ],
        "band": {"f": band[:, 0], "lower": factor * band[:, 1], "upper": factor * band[:, 2]},
        "before": _branch(curve.before, phases.before, factor),
        "after": _branch(curve.after, phases.after, factor),
    }


def _branch(branch: ModelCurve, phase: Floats, factor: float) -> dict[str, Any]:
    return {**_polar(branch, phase, factor), "visited": branch.visited.astype(int)}


def _polar(curve: MeasuredCurve | ModelCurve, phase: Floats, factor: float) -> dict[str, Any]:
    """f [Hz], a (`drawn_units`), p [degrees]; factor: on m/N"""
    return {"f": curve.frequency, "a": factor * np.abs(curve.receptance), "p": phase}


SECTION = ReportSection("response", "Frequency response", render, "Response")
