"""Frequency responses in mm/N: the whole branch, and what sweeps would see of it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import sweep
from updamp.pictures.style import GREY, INK, figure, shades

MM = 1e3  # m/N to mm/N


def frequency_responses(path: Path, mode: str, curves: Sequence[ResponseCurve], point: str) -> None:
    """Receptance of the first harmonic at `point`, all force levels of a mode; jumps of an up sweep point up in
    frequency, those of a down sweep down."""
    curves = sorted(curves, key=lambda curve: curve.force)
    with figure(path, 10.5, 4.8) as drawing:
        linear, logarithmic = drawing.subplots(1, 2, sharex=True)
        logarithmic.set_yscale("log")
        for ax in (linear, logarithmic):
            for curve, colour in zip(curves, shades(len(curves)), strict=True):
                _branch(ax, curve, point, colour)
            ax.set_xlabel("frequency [Hz]")
            ax.margins(x=0)
        linear.set_ylim(bottom=0)
        linear.set_ylabel("receptance, first harmonic [mm/N]")
        linear.set_title(f"{mode} at {point}")
        logarithmic.set_title("the same, logarithmic")
        handles = [
            Line2D([], [], color=colour, label=f"{curve.force:g} N")
            for curve, colour in zip(curves, shades(len(curves)), strict=True)
        ]
        drawing.legend(handles=handles + _key_of_marks(curves), loc="outside lower center", ncols=len(handles) + 3)


def _branch(ax: Axes, curve: ResponseCurve, point: str, colour: Any) -> None:
    size = MM * np.abs(curve.receptance(point))
    ax.plot(curve.frequency, size, color=colour)
    frequency, peak = curve.peak(point)
    ax.plot(frequency, MM * peak, "o", color=colour, markeredgecolor="white", markersize=6)
    for upwards, marker in ((True, ">"), (False, "<")):
        swept = sweep(curve.frequency, upwards)
        for place in swept.jump_after:
            start, end = swept.visited[place], swept.visited[place + 1]
            at = curve.frequency[start]
            ax.plot([at, at], [size[start], size[end]], ":", color=colour, linewidth=1.1)
            ax.plot(at, size[start], marker, color=colour, markeredgecolor=INK, markeredgewidth=0.6, markersize=7)
    if curve.stopped:
        ax.plot(curve.frequency[-1], size[-1], "x", color=colour, markersize=8, markeredgewidth=2)


def _key_of_marks(curves: Sequence[ResponseCurve]) -> list[Line2D]:
    marks = [("o", "peak")]
    if any(len(sweep(curve.frequency, True).jumps) for curve in curves):
        marks.append((">", "jump, sweep up"))
    if any(len(sweep(curve.frequency, False).jumps) for curve in curves):
        marks.append(("<", "jump, sweep down"))
    if any(curve.stopped for curve in curves):
        marks.append(("x", "branch stopped"))
    return [Line2D([], [], marker=mark, linestyle="", color=GREY, label=label) for mark, label in marks]
