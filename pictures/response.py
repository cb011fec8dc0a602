"""Frequency responses in mm/N: the resonances of all force levels, and the whole window beside the blades alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.smooth_branch import smooth_branch
from updamp.hbm.continuation.sweeps import swept
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.pictures.branch_lines import HATCH, draw_branch, hatch_gaps, key_of_stability
from updamp.pictures.style import GREY, INK, figure, shades
from updamp.pictures.variants import PeakPoint

MM = 1e3  # m/N to mm/N
BAND = 0.2  # opacity of the numerical error
WIDEST, FINEST = 3.2, 1.4  # lines, of the lowest and of the highest force: those that coincide are all seen
SHOWN = 0.04  # of the largest peak: frequencies at which all is lower are left out beside the resonances
ALONE = "without damper"
PEAK_ALONE = "D"  # marker where there is no curve
DETACHED = (0, (5, 1, 1, 1))  # dashes and dots: of branches beside a curve


@dataclass(frozen=True, eq=False)
class LinearResponse:
    """Of the blades without damper. frequency: (n,) [Hz]; receptance: (n,) complex [m/N]"""

    frequency: NDArray[np.float64]
    receptance: NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Responses:
    """All force levels of a mode, rising, at one point.

    finer: curves with more harmonics; stability: by force, as far as it is known
    alone: the response without damper, None where it is not known
    detached: branches that are no part of any of the curves, by force
    peaks: at forces that have no curve; note: what is to be known of them all, above the picture
    """

    mode: str
    point: str
    curves: Sequence[ResponseCurve]
    finer: Sequence[ResponseCurve] = ()
    stability: Mapping[float, BranchStability] | None = None
    alone: LinearResponse | None = None
    detached: Mapping[float, Sequence[ResponseCurve]] = field(default_factory=dict)
    peaks: Sequence[PeakPoint] = ()
    note: str = ""

    def levels(self) -> list[tuple[ResponseCurve, Any, float]]:
        """Curves with their colours and widths"""
        curves = sorted(self.curves, key=lambda curve: curve.force)
        widths = np.linspace(WIDEST, FINEST, len(curves)).tolist() if len(curves) > 1 else [FINEST]
        return [(one, self.colours()[one.force], width) for one, width in zip(curves, widths, strict=True)]

    def colours(self) -> Mapping[float, Any]:
        """By force, from the lowest, with a curve or a peak alone"""
        forces = sorted({*(one.force for one in self.curves), *(one.force for one in self.peaks)})
        return dict(zip(forces, shades(len(forces)), strict=True))

    def stability_of(self, curve: ResponseCurve) -> BranchStability | None:
        return (self.stability or {}).get(curve.force)


def frequency_responses(path: Path, drawn: Responses) -> None:
    """Receptance of the first harmonic; jumps of an up sweep point up in frequency, those of a down sweep down."""
    with figure(path, 11.0, 4.9) as drawing:
        linear, logarithmic = drawing.subplots(1, 2)
        for ax in (linear, logarithmic):
            for curve, colour, width in drawn.levels():
                _level(ax, drawn, curve, colour, width)
            for one in drawn.peaks:
                colour = drawn.colours()[one.force]
                ax.plot(one.frequency, MM * one.receptance, PEAK_ALONE, color=colour, markersize=7, zorder=4)
            ax.set_xlabel("frequency [Hz]")
        linear.set_xlim(*_resonances(drawn))
        linear.set_ylim(bottom=0)
        linear.set_ylabel("receptance, first harmonic [mm/N]")
        linear.set_title(f"{drawn.mode} at {drawn.point}")
        logarithmic.set_yscale("log")
        logarithmic.set_title("logarithmic" if drawn.alone is None else "logarithmic, and without damper")
        if drawn.alone is not None:
            size = MM * np.abs(drawn.alone.receptance)
            logarithmic.plot(drawn.alone.frequency, size, color=GREY, linewidth=1.1, zorder=1)
        logarithmic.margins(x=0)
        if drawn.note:
            drawing.suptitle(drawn.note, fontsize="small", color=INK)
        _keys(drawing, drawn)


def _keys(drawing: Figure, drawn: Responses) -> None:
    """Levels to the right, marks below."""
    levels = [
        Line2D([], [], color=colour, linewidth=width, label=f"{curve.force:g} N")
        for curve, colour, width in drawn.levels()
    ]
    levels += [
        Line2D([], [], marker=PEAK_ALONE, linestyle="", color=drawn.colours()[one.force], label=f"{one.force:g} N")
        for one in drawn.peaks
    ]
    drawing.legend(handles=levels, title="force", loc="outside right upper")
    marks = [*_key_of_marks(drawn), *key_of_stability(drawn.stability or {})]
    drawing.legend(handles=marks, loc="outside lower center", ncols=4)


def _level(ax: Axes, drawn: Responses, curve: ResponseCurve, colour: Any, width: float) -> None:
    for finer in (one for one in drawn.finer if one.force == curve.force):
        _band(ax, curve, finer, drawn.point, colour)
    draw_branch(ax, curve, drawn.point, colour, drawn.stability_of(curve), linewidth=width)
    for branch in drawn.detached.get(curve.force, ()):
        for part in smooth_branch(branch, drawn.point).pieces():
            ax.plot(part.frequency, MM * np.abs(part.receptance), color=colour, linewidth=FINEST, linestyle=DETACHED)
    frequency, peak = curve.peak(drawn.point)
    ax.plot(frequency, MM * peak, "o", color=colour, markeredgecolor="white", markersize=6, zorder=3)
    size = MM * np.abs(curve.receptance(drawn.point))
    for upwards, marker in ((True, ">"), (False, "<")) if curve.complete else ():
        seen = swept(curve, upwards)
        for place in seen.jump_after:
            start, end = seen.visited[place], seen.visited[place + 1]
            at = curve.frequency[start]
            ax.plot([at, at], [size[start], size[end]], ":", color=colour, linewidth=1.1)
            ax.plot(
                at, size[start], marker, color=colour, markeredgecolor=INK, markeredgewidth=0.6, markersize=7, zorder=4
            )
    if not curve.complete:
        hatch_gaps(ax, curve, colour)


def _resonances(drawn: Responses) -> tuple[float, float]:
    """Frequencies with something to see on a linear scale, and a little more."""
    shown = [*drawn.curves, *(branch for beside in drawn.detached.values() for branch in beside)]
    sizes = [np.abs(curve.receptance(drawn.point)) for curve in shown]
    largest = max(float(size.max()) for size in sizes)
    seen = [curve.frequency[size > SHOWN * largest] for curve, size in zip(shown, sizes, strict=True)]
    alone = [one.frequency for one in drawn.peaks]
    places = np.concatenate([*seen, *(curve.gaps().ravel() for curve in drawn.curves if not curve.complete), alone])
    margin = 0.06 * float(np.ptp(places))
    ends = [float(f) for curve in drawn.curves for f in (curve.frequency.min(), curve.frequency.max())] + alone
    return max(float(places.min()) - margin, min(ends)), min(float(places.max()) + margin, max(ends))


def _band(ax: Axes, curve: ResponseCurve, finer: ResponseCurve, point: str, colour: Any) -> None:
    """Shaded: between a curve and the one with more harmonics, where both are complete."""
    if curve.complete and finer.complete:
        one, other = smooth_branch(curve, point), smooth_branch(finer, point)
        frequency = np.concatenate([one.frequency, other.frequency[::-1]])
        size = MM * np.abs(np.concatenate([one.receptance, other.receptance[::-1]]))
        ax.fill(frequency, size, color=colour, alpha=BAND, linewidth=0)


def _key_of_marks(drawn: Responses) -> list[Artist]:
    curves, marks = drawn.curves, [("o", "peak")]
    if any(len(swept(curve, True).jumps) for curve in curves):
        marks.append((">", "jump, sweep up"))
    if any(len(swept(curve, False).jumps) for curve in curves):
        marks.append(("<", "jump, sweep down"))
    key: list[Artist] = [Line2D([], [], marker=mark, linestyle="", color=GREY, label=label) for mark, label in marks]
    if drawn.peaks:
        key.append(
            Line2D([], [], marker=PEAK_ALONE, linestyle="", color=GREY, label="peak followed in force, no curve")
        )
    if not all(curve.complete for curve in curves):
        key.append(Patch(facecolor="none", edgecolor=GREY, hatch=HATCH, label="not followed"))
    if drawn.finer:
        key.append(Patch(facecolor=GREY, alpha=2 * BAND, label="band: change with more harmonics"))
    if any(drawn.detached.values()):
        key.append(Line2D([], [], color=GREY, linewidth=FINEST, linestyle=DETACHED, label="no part of the curve"))
    if drawn.alone is not None:
        key.append(Line2D([], [], color=GREY, linewidth=1.1, label=ALONE))
    return key
