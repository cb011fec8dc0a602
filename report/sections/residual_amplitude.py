"""Residual of the calibrated model against the displacement amplitude: shows what grows or falls with it."""

from collections import defaultdict
from typing import Any

import numpy as np

from updamp.comparison.comparison import Comparison
from updamp.report.markup import drawn_units, figure_element, level_word
from updamp.report.section import Content, Report, ReportSection

INTRODUCTION = """<p>Positive: measured above the model, or ahead of it in phase. Shown for the mode, channel and sweep
chosen above, {level}s in colours; the grey strip holds 95 % of the points of an adequate model.</p>"""


def render(report: Report) -> Content | None:
    points = _points(report.comparison)
    if not points:
        return None
    level = level_word(report.comparison)
    html = INTRODUCTION.format(level=level) + figure_element(
        "residual-amplitude",
        "Residual of amplitude and of phase in standard deviations against the displacement amplitude, coloured by "
        f"{level}.",
        height=380,
    )
    return Content(html, data={"points": points}, scripts=("selection.js", "residual_amplitude.js"))


def _points(comparison: Comparison) -> list[dict[str, Any]]:
    """Of each run at each channel: x displacement (`drawn_units`), amplitude and phase [standard deviations], f [Hz]"""
    found: dict[tuple[str, str], list[tuple[float, ...]]] = defaultdict(list)
    factor = drawn_units(comparison).displacement[1]
    measured = {
        (curve.run, curve.channel, each.repeat): (each.frequency, factor * np.abs(each.receptance) * each.force)
        for curve in comparison.curves
        for each in curve.measured
    }
    for r in comparison.residuals:
        if (r.run, r.channel, r.repeat) in measured:
            frequency, displacement = measured[r.run, r.channel, r.repeat]
            at = int(np.argmin(np.abs(frequency - r.frequency)))
            found[r.run, r.channel].append((float(displacement[at]), r.amplitude, r.phase, r.frequency))
    points = []
    for curve in comparison.curves:
        if (curve.run, curve.channel) in found:
            x, amplitude, phase, f = np.array(found[curve.run, curve.channel]).T
            points.append(
                {"mode": curve.mode, "level": curve.level, "up": curve.upwards, "channel": curve.channel,
                 "x": x, "amplitude": amplitude, "phase": phase, "f": f}
            )  # fmt: skip
    return points


SECTION = ReportSection("amplitude", "Residual against amplitude", render, "Amplitude")
