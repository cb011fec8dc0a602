"""Figures for notebooks: receptance with its phase, resonance over force, model over measurement."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from updamp.comparison.comparison import CurvePair
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.smooth_branch import smooth_branch
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.pictures.branch_lines import hatch_gaps
from updamp.pictures.style import BLUE, GREY, VERMILLION, NotebookFigure, figure, notebook_figure, shades

MM = 1e3  # m/N to mm/N
_LEGEND = 10  # entries at most; more would cover the curves
_TICKS = 10  # forces written below the axis, at most


def receptance_figure(drawn: Sequence[tuple[ResponseCurve, str]]) -> NotebookFigure:
    """Amplitude and phase of the first harmonic over frequency. drawn: curves, each with the point to be drawn"""
    with notebook_figure(8.0, 5.6, rows=2, share=True) as (drawing, (amplitude, phase)):
        for (curve, point), colour in zip(drawn, shades(len(drawn)), strict=True):
            label = f"{curve.mode}, {curve.force:g} N, {point}"
            for piece in smooth_branch(curve, point).pieces():
                amplitude.plot(piece.frequency, MM * np.abs(piece.receptance), color=colour, label=label)
                label = ""  # the key has each curve once
                phase.plot(piece.frequency, _degrees(piece.receptance), color=colour)
            if len(curve) and not curve.complete:
                hatch_gaps(amplitude, curve, colour)
        amplitude.set_ylim(bottom=0)
        amplitude.set_ylabel("receptance, first harmonic [mm/N]")
        phase.set_ylabel("phase against the force [deg]")
        phase.set_xlabel("frequency [Hz]")
        phase.margins(x=0)
        _legend(amplitude)
    return drawing


def _degrees(receptance: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Without jumps by 360 degrees, beginning between -180 and 180."""
    return np.asarray(np.degrees(np.unwrap(np.angle(receptance))))


def resonance_figure(curve: ResonanceCurve) -> NotebookFigure:
    """Frequency and receptance at resonance over force; dots at the forces that were asked for."""
    at_forces = curve.asked_for.astype(bool)  # of no type where no point was found
    values = (curve.frequency, MM * np.abs(curve.receptance))
    with notebook_figure(8.0, 5.6, rows=2, share=True) as (drawing, axes):
        for ax, value, label in zip(axes, values, ("resonance [Hz]", "receptance [mm/N]"), strict=True):
            ax.plot(curve.force, value, color=BLUE)
            ax.plot(curve.force[at_forces], value[at_forces], "o", color=BLUE, markersize=5)
            ax.set_ylabel(label)
            ax.ticklabel_format(axis="y", useOffset=False)
        axes[0].set_title(f"{curve.mode} at {curve.point}")
        axes[-1].set_xlabel("force [N]")
        if len(forces := curve.force[at_forces]) > 1:
            axes[-1].set_xscale("log")
            axes[-1].set_xticks(forces[:: -(-len(forces) // _TICKS)])
            axes[-1].set_xticks([], minor=True)
            axes[-1].xaxis.set_major_formatter(lambda force, _: f"{force:g}")
    return drawing


def comparison_figure(pairs: Sequence[CurvePair], unit: tuple[str, float] = ("mm/N", MM)) -> NotebookFigure:
    """Size of the receptance in every run at every channel: measured, model as given, model calibrated.

    unit: and what numbers in m/N are multiplied by
    """
    columns, rows = _grid(len(pairs))
    with notebook_figure(5.0 * columns, 2.8 * rows, rows, columns) as (drawing, axes):
        _draw_pairs(axes, pairs, unit)
        _legend(axes[0])
    return drawing


def comparison_picture(
    path: Path, title: str, pairs: Sequence[CurvePair], unit: tuple[str, float] = ("mm/N", MM)
) -> None:
    """The same as a file, the key below."""
    columns, rows = _grid(len(pairs))
    with figure(path, 5.0 * columns, 2.6 * rows + 0.8) as drawing:
        axes = list(drawing.subplots(rows, columns, squeeze=False).ravel())
        _draw_pairs(axes, pairs, unit)
        drawing.suptitle(title, fontweight="bold", x=0.01, ha="left")
        drawing.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _grid(count: int) -> tuple[int, int]:
    """Columns and rows"""
    columns = min(count, 2)
    return columns, -(-count // columns)


def _draw_pairs(axes: Sequence[Axes], pairs: Sequence[CurvePair], unit: tuple[str, float]) -> None:
    name, factor = unit
    for ax, pair in zip(axes, pairs, strict=False):
        if len(pair.band):
            frequency, low, high = pair.band.T
            ax.fill_between(frequency, factor * low, factor * high, color=BLUE, alpha=0.15, linewidth=0)
        for one in pair.measured:
            ax.plot(one.frequency, factor * np.abs(one.receptance), ".", color=GREY, markersize=4)
        for curve, colour in ((pair.before, VERMILLION), (pair.after, BLUE)):
            ax.plot(curve.frequency, factor * np.abs(curve.receptance), color=colour, linewidth=1.2)
        ax.set_title(f"{pair.run}, {pair.channel}")
        ax.set_xlabel("frequency [Hz]")
        ax.set_ylabel(f"receptance [{name}]")
        ax.set_ylim(bottom=0)
    for ax in axes[len(pairs) :]:
        ax.set_visible(False)
    for mark, colour, label in ((".", GREY, "measured"), ("-", VERMILLION, "as given"), ("-", BLUE, "calibrated")):
        axes[0].plot([], [], mark, color=colour, label=label)
    if any(len(pair.band) for pair in pairs):
        axes[0].fill_between([], [], [], color=BLUE, alpha=0.15, label="95 % of repeats")


def _legend(ax: Axes) -> None:
    if len(ax.get_legend_handles_labels()[0]) <= _LEGEND:
        ax.legend(fontsize="small")
