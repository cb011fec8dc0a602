"""Responses of several variants of a rig over each other, and their peaks against force."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.pictures.branch_lines import draw_branch, hatch_gaps
from updamp.pictures.style import BLUE, GREEN, GREY, INK, ORANGE, SKY, VERMILLION, figure, shades

MM = 1e3  # m/N to mm/N
WIDEST, FINEST = 4.0, 1.3  # lines
SHOWN = 0.02  # of the largest peak: frequencies at which all is lower are left out
FEW = (BLUE, VERMILLION, GREEN, ORANGE, SKY, INK)  # told apart more easily than shades, as long as they last


@dataclass(frozen=True, eq=False)
class DrawnCurve:
    """point: where its receptance is taken; peak: frequency [Hz] and receptance [m/N] of what is marked"""

    curve: ResponseCurve
    point: str
    peak: tuple[float, float]


@dataclass(frozen=True)
class PeakPoint:
    """force: [N]; frequency: [Hz]; receptance: [m/N]; complete: whether the curve it was read off is, or what was
    followed"""

    force: float
    frequency: float
    receptance: float
    complete: bool


def variant_responses(
    path: Path,
    title: str,
    curves: Mapping[str, DrawnCurve],
    measured: Sequence[tuple[str, float]] = (),
    in_order: bool = False,
) -> None:
    """curves: by what they are called; those drawn first are wider, so that curves that coincide are all seen
    measured: resonances of a test to be marked, (label, frequency [Hz]); in_order: colours go from dark to light
    """
    palette = shades(len(curves)) if in_order else colours(len(curves))
    widths = np.linspace(WIDEST, FINEST, len(curves)) if len(curves) > 1 else [FINEST]
    with figure(path, 8.2, 4.6) as drawing:
        ax = drawing.subplots()
        for (label, drawn), colour, width in zip(curves.items(), palette, widths, strict=True):
            curve, (frequency, peak) = drawn.curve, drawn.peak
            draw_branch(ax, curve, drawn.point, colour, None, linewidth=float(width))
            ax.plot([], [], color=colour, label=label if curve.complete else f"{label}, not complete")
            ax.plot(frequency, MM * peak, "o", color=colour, markeredgecolor="white", markersize=5)
            if not curve.complete:
                hatch_gaps(ax, curve, colour)
        for label, frequency in measured:
            ax.axvline(frequency, color=GREY, linestyle="--", linewidth=1.0, label=label)
        ax.set(xlabel="frequency [Hz]", ylabel="receptance, first harmonic [mm/N]", title=title)
        ax.set_ylim(bottom=0)
        ax.set_xlim(*_shown(curves, [frequency for _, frequency in measured]))
        drawing.legend(loc="outside right upper", fontsize=8.5)


def colours(count: int) -> Sequence[Any]:
    return FEW[:count] if count <= len(FEW) else shades(count)


def _shown(drawn: Mapping[str, DrawnCurve], marked: Sequence[float]) -> tuple[float, float]:
    """Frequencies with something to see, and a little more."""
    largest = max(one.peak[1] for one in drawn.values())
    seen = [one.curve.frequency[np.abs(one.curve.receptance(one.point)) > SHOWN * largest] for one in drawn.values()]
    places = np.concatenate([*seen, np.asarray(marked)])
    margin = 0.03 * float(np.ptp(places))
    return float(places.min()) - margin, float(places.max()) + margin


def peaks_against_force(path: Path, title: str, peaks: Mapping[str, Sequence[PeakPoint]]) -> None:
    """Receptance and frequency of the peaks over the force. peaks: label -> one a force level; hollow where the curve
    is not complete"""
    with figure(path, 10.0, 4.2) as drawing:
        receptance, frequency = drawing.subplots(1, 2, sharex=True)
        for (label, points), colour in zip(peaks.items(), colours(len(peaks)), strict=True):
            ordered = sorted(points, key=lambda one: one.force)
            _points(receptance, ordered, [MM * one.receptance for one in ordered], colour, label)
            _points(frequency, ordered, [one.frequency for one in ordered], colour, label)
        receptance.set(ylabel="peak receptance [mm/N]", title=title)
        from_zero(receptance)
        frequency.set(ylabel="frequency of the peak [Hz]", title="its frequency")
        frequency.ticklabel_format(axis="y", useOffset=False)
        forces = sorted({one.force for points in peaks.values() for one in points})
        for ax in (receptance, frequency):
            force_axis(ax, forces)
        drawing.legend(*receptance.get_legend_handles_labels(), loc="outside right upper", fontsize=8.5)


def _points(ax: Axes, points: Sequence[PeakPoint], values: Sequence[float], colour: Any, label: str) -> None:
    ax.plot([one.force for one in points], values, color=colour, label=label)
    for one, value in zip(points, values, strict=True):
        ax.plot(one.force, value, "o", color=colour, markerfacecolor=colour if one.complete else "white", markersize=5)


def from_zero(ax: Axes) -> None:
    """The scale begins at zero and ends above what is drawn, however flat that is."""
    ax.set_ylim(0.0, 1.08 * float(ax.dataLim.ymax))


def force_axis(ax: Axes, forces: Sequence[float]) -> None:
    ax.set_xlabel("force [N]")
    if len(forces) > 1:
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(FixedLocator(list(forces)))
        ax.xaxis.set_minor_locator(NullLocator())
        ax.xaxis.set_major_formatter(lambda force, _: f"{force:g}")
