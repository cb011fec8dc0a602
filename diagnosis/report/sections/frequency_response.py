"""Measured and computed receptance over each other, one curve or all force levels."""

from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.comparison import Comparison, CurvePair, ModelCurve
from updamp.diagnosis.report.markup import figure
from updamp.diagnosis.report.section import Content, Report, Section

Complex = NDArray[np.complex128]
MM = 1e3  # m/N to mm/N

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
    centres = _phase_centres(curves)
    plot = figure(
        "response",
        "Receptance against frequency, amplitude above and phase below: measured repeats as points with their "
        "95 % band, the model before calibration dashed, calibrated solid, parts no slow sweep visits dotted.",
        "Points: measured, one symbol a repeat; grey: 95 % of what a repeat gives. Blue: calibrated model; thin "
        "dashed: before calibration; dotted: what a slow sweep in this direction jumps over. Zoom by dragging, "
        "double click for all.",
        500,
    )
    data = {
        "curves": [_curve_data(curve, centres[curve.mode, curve.channel]) for curve in curves],
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


def _phase_centres(curves: tuple[CurvePair, ...]) -> dict[tuple[str, str], float]:
    """Middle of the phases measured for a mode at a channel [degrees], so that none of its curves is cut in two."""
    directions: dict[tuple[str, str], complex] = defaultdict(complex)
    for curve in curves:
        for measured in curve.measured:
            known = measured.receptance[np.isfinite(measured.receptance) & (measured.receptance != 0)]
            if len(known) == 0:
                continue
            ends = known[[0, -1]] / np.abs(known[[0, -1]])
            directions[curve.mode, curve.channel] += complex(np.mean(ends * np.array([-1j, 1j])))
    return {key: float(np.degrees(np.angle(value))) for key, value in directions.items()}


def _curve_data(curve: CurvePair, centre: float) -> dict[str, Any]:
    band = curve.band
    return {
        "run": curve.run,
        "mode": curve.mode,
        "level": curve.level,
        "up": curve.upwards,
        "channel": curve.channel,
        "measured": [
            {"repeat": each.repeat, **_polar(each.frequency, each.receptance, centre)} for each in curve.measured
        ],
        "band": {"f": band[:, 0], "lower": MM * band[:, 1], "upper": MM * band[:, 2]},
        "before": _branch(curve.before, centre),
        "after": _branch(curve.after, centre),
    }


def _branch(branch: ModelCurve, centre: float) -> dict[str, Any]:
    return {**_polar(branch.frequency, branch.receptance, centre), "visited": branch.visited.astype(int)}


def _polar(frequency: NDArray[np.float64], receptance: Complex, centre: float) -> dict[str, Any]:
    """f [Hz], a [mm/N], p [degrees] within half a turn about the centre"""
    turned = receptance * np.exp(-1j * np.radians(centre))
    return {"f": frequency, "a": MM * np.abs(receptance), "p": centre + np.degrees(np.angle(turned))}


SECTION = Section("response", "Frequency response", render, "Response")
