"""Frequency responses in mm/N: the whole branch, and what sweeps would see of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import sweep
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.pictures.branch_lines import draw_branch, key_of_stability
from updamp.pictures.style import GREY, INK, figure, shades

MM = 1e3  # m/N to mm/N
HATCH = "////"  # of what was not followed
BAND = 0.2  # opacity of the numerical error


def frequency_responses(
    path: Path,
    mode: str,
    curves: Sequence[ResponseCurve],
    point: str,
    finer: Sequence[ResponseCurve] = (),
    stability: Mapping[float, BranchStability] | None = None,
) -> None:
    """finer: the same curves with more harmonics, drawn thin; stability: by force, as far as it is known.

    Receptance of the first harmonic at `point`, all force levels of a mode; jumps of an up sweep point up in
    frequency, those of a down sweep down."""
    stability = stability or {}
    curves = sorted(curves, key=lambda curve: curve.force)
    with figure(path, 10.5, 4.8) as drawing:
        linear, logarithmic = drawing.subplots(1, 2, sharex=True)
        logarithmic.set_yscale("log")
        for ax in (linear, logarithmic):
            for curve, colour in zip(curves, shades(len(curves)), strict=True):
                _branch(ax, curve, point, colour, stability.get(curve.force))
                for other in (one for one in finer if one.force == curve.force):
                    _band(ax, curve, other, point, colour)
                    draw_branch(ax, other, MM * np.abs(other.receptance(point)), colour, None, linewidth=0.6)
            ax.set_xlabel("frequency [Hz]")
            ax.margins(x=0)
        linear.set_ylim(bottom=0)
        linear.set_ylabel("receptance, first harmonic [mm/N]")
        linear.set_title(f"{mode} at {point}")
        logarithmic.set_title("the same, logarithmic")
        handles: list[Artist] = [
            Line2D([], [], color=colour, label=f"{curve.force:g} N")
            for curve, colour in zip(curves, shades(len(curves)), strict=True)
        ]
        drawing.legend(
            handles=[*handles, *_key_of_marks(curves, finer), *key_of_stability(stability)],
            loc="outside lower center",
            ncols=min(len(handles) + 3, 5),
        )


def hatch_gaps(ax: Axes, curve: ResponseCurve, colour: Any) -> None:
    """Hatched: frequencies between which the branch of an incomplete curve was not followed, or where it ends."""
    for one, other in (*curve.gaps(), (curve.frequency[-1],) * 2):
        ax.axvspan(min(one, other), max(one, other), facecolor="none", edgecolor=colour, hatch=HATCH, linewidth=1.0)


def _branch(ax: Axes, curve: ResponseCurve, point: str, colour: Any, stability: BranchStability | None) -> None:
    size = MM * np.abs(curve.receptance(point))
    draw_branch(ax, curve, size, colour, stability)
    frequency, peak = curve.peak(point)
    ax.plot(frequency, MM * peak, "o", color=colour, markeredgecolor="white", markersize=6)
    for upwards, marker in ((True, ">"), (False, "<")) if curve.complete else ():
        swept = sweep(curve.frequency, upwards)
        for place in swept.jump_after:
            start, end = swept.visited[place], swept.visited[place + 1]
            at = curve.frequency[start]
            ax.plot([at, at], [size[start], size[end]], ":", color=colour, linewidth=1.1)
            ax.plot(at, size[start], marker, color=colour, markeredgecolor=INK, markeredgewidth=0.6, markersize=7)
    if not curve.complete:
        hatch_gaps(ax, curve, colour)


def _band(ax: Axes, curve: ResponseCurve, finer: ResponseCurve, point: str, colour: Any) -> None:
    """Shaded: between a curve and the one with more harmonics, where both are complete."""
    if curve.complete and finer.complete:
        frequency = np.concatenate([curve.frequency, finer.frequency[::-1]])
        size = MM * np.abs(np.concatenate([curve.receptance(point), finer.receptance(point)[::-1]]))
        ax.fill(frequency, size, color=colour, alpha=BAND, linewidth=0)


def _key_of_marks(curves: Sequence[ResponseCurve], finer: Sequence[ResponseCurve] = ()) -> list[Artist]:
    marks = [("o", "peak")]
    if any(len(sweep(curve.frequency, True).jumps) for curve in curves):
        marks.append((">", "jump, sweep up"))
    if any(len(sweep(curve.frequency, False).jumps) for curve in curves):
        marks.append(("<", "jump, sweep down"))
    key: list[Artist] = [Line2D([], [], marker=mark, linestyle="", color=GREY, label=label) for mark, label in marks]
    if not all(curve.complete for curve in curves):
        key.append(Patch(facecolor="none", edgecolor=GREY, hatch=HATCH, label="not followed"))
    if finer:
        key.append(Line2D([], [], color=GREY, linewidth=0.6, label="more harmonics, and the band to them"))
    return key
