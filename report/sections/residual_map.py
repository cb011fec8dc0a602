"""Where the calibrated model fails: residual by mode, force level and frequency, linked with the curves."""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from updamp.comparison.comparison import PointResidual
from updamp.report.markup import RESIDUAL_SCALE, figure_element, level_name
from updamp.report.section import Content, Report, ReportSection

COLUMNS = 20  # of frequency; each as wide as it takes to hold as many points as the others
WORST = 6
ROW_HEIGHT = 34  # px

INTRODUCTION = """<p>Each cell is the misfit of the calibrated model in one stretch of frequency, as a multiple of the
scatter: 1 is what scatter alone gives. <span class="screen">Click on a cell, or on one of the places below, to see the
curve it belongs to.</span></p>"""


def render(report: Report) -> Content | None:
    comparison = report.comparison
    if not any(math.isfinite(r.size) for r in comparison.residuals):
        return None
    known = [r for r in comparison.residuals if math.isfinite(r.size)]
    upwards = {curve.run: curve.upwards for curve in comparison.curves}
    modes, unit = dict.fromkeys(r.mode for r in known), comparison.level_unit
    maps = [_map_of([r for r in known if r.mode == mode], upwards, unit) for mode in modes]
    height = 150 + ROW_HEIGHT * max(max(len(each["rows"]) for each in maps), 6)  # room for the colour bar
    html = INTRODUCTION + figure_element(
        "residual-map",
        "Heat map of the residual's size: one panel a mode, one row a force level and sweep direction, frequency to "
        "the right. The largest are listed below it.",
        height=height,
    )
    left_out = len(comparison.residuals) - len(known)
    if left_out:
        html += f'<p class="note">{left_out} points without a solution of the model are left out.</p>'
    html += '<div id="worst-places" class="places" role="group" aria-label="Largest residuals"></div>'
    data = {"maps": maps, "scale": RESIDUAL_SCALE, "worst": WORST}
    return Content(html, data=data, scripts=("selection.js", "residual_map.js"))


def _map_of(residuals: Sequence[PointResidual], upwards: Mapping[str, bool], unit: str) -> dict[str, Any]:
    """Of one mode. Rows by level and direction, lowest first; a cell knows its size and the channel worst in it."""
    frequency = np.array([r.frequency for r in residuals])
    edges = np.unique(np.quantile(frequency, np.linspace(0, 1, min(COLUMNS, len(np.unique(frequency))) + 1)))
    if len(edges) < 2:  # all points at one frequency
        edges = edges[0] + np.array([-0.5, 0.5])
    columns = np.clip(np.searchsorted(edges, frequency, side="right") - 1, 0, len(edges) - 2)
    cells: dict[tuple[float, bool], dict[int, list[PointResidual]]] = defaultdict(lambda: defaultdict(list))
    for residual, column in zip(residuals, columns, strict=True):
        cells[residual.level, upwards.get(residual.run, True)][int(column)].append(residual)
    keys = sorted(cells)
    both = len({up for _, up in keys}) > 1
    return {
        "mode": residuals[0].mode,
        "edges": edges,
        "rows": [level_name(level, unit) + ((" ▲" if up else " ▼") if both else "") for level, up in keys],
        "levels": [level for level, _ in keys],
        "up": [up for _, up in keys],
        "cells": [[_cell(cells[key].get(i, ())) for i in range(len(edges) - 1)] for key in keys],
    }


def _cell(residuals: Sequence[PointResidual]) -> dict[str, Any] | None:
    """Root mean square over the cell's points, and where it is worst; None without points"""
    if not residuals:
        return None
    by_channel = {
        channel: _rms([r.size for r in residuals if r.channel == channel]) for channel in {r.channel for r in residuals}
    }
    worst = max(sorted(by_channel), key=lambda channel: by_channel[channel])
    at = max((r for r in residuals if r.channel == worst), key=lambda r: r.size)
    mean = [
        float(np.mean([getattr(r, name) for r in residuals if r.channel == worst])) for name in ("amplitude", "phase")
    ]
    return {
        "size": _rms([r.size for r in residuals]), "channel": worst, "f": at.frequency, "run": at.run,
        "amplitude": mean[0], "phase": mean[1], "n": len(residuals),
    }  # fmt: skip


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


SECTION = ReportSection("misfit", "Where the model fails", render, "Misfit")
