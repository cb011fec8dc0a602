"""Interactive figures of a family's response curves."""

from typing import Any

import numpy as np

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.parameter_study.families import Family
from updamp.parameter_study.family_pictures import groups, known
from updamp.parameter_study.solved_study import SolvedStudy
from updamp.report.markup import LEVELS, MANY_LEVELS

MM = 1e3  # m/N to mm/N


def response_figures(solved: SolvedStudy, family: Family) -> dict[str, Any]:
    """name -> plotly figure, one for curves that are drawn over each other"""
    figures = {}
    for number, (title, names) in enumerate(groups(family)):
        curves = known(solved, names.values())
        there = {label: name for label, name in names.items() if name in curves}
        palette = LEVELS if len(there) <= len(LEVELS) else MANY_LEVELS
        traces = [
            _trace(label, curves[name], solved.point(name.variant), palette[i % len(palette)])
            for i, (label, name) in enumerate(there.items())
        ]
        if traces:
            figures[f"{family.name}-{number}"] = {
                "data": traces,
                "layout": {
                    "title": {"text": title},
                    "xaxis": {"title": {"text": "frequency [Hz]"}},
                    "yaxis": {"title": {"text": "receptance [mm/N]"}, "rangemode": "tozero"},
                },
            }
    return figures


def _trace(label: str, curve: ResponseCurve, point: str, colour: str) -> dict[str, Any]:
    """A gap in the curve is a gap in the line."""
    gaps = np.flatnonzero(curve.after_gap)
    return {
        "type": "scatter", "mode": "lines", "name": label if curve.complete else f"{label}, not complete",
        "x": np.insert(curve.frequency, gaps, np.nan),
        "y": np.insert(MM * np.abs(curve.receptance(point)), gaps, np.nan),
        "line": {"color": colour, "width": 2}, "connectgaps": False,
    }  # fmt: skip
