"""The resonance of a mode against force: followed, and read off response curves."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.pictures.style import BLUE, VERMILLION, figure
from updamp.pictures.variants import PeakPoint, force_axis, from_zero

MM = 1e3  # m/N to mm/N
# Relative: what a resonance drifts by from run to run where a test states nothing (docs/measurements.md). An axis that
# shows less makes round-off look like a difference.
LEAST_SHOWN = 1e-4


def resonance_against_force(path: Path, mode: str, followed: ResonanceCurve | None, peaks: Sequence[PeakPoint]) -> None:
    """Receptance, frequency and loss factor. followed: the line, None where there is none; peaks: of response curves,
    hollow where they are not complete"""
    lowest = min((one.force for one in peaks), default=0.0)
    with figure(path, 12.0, 4.0) as drawing:
        axes: Sequence[Axes] = drawing.subplots(1, 3, sharex=True)
        shown = np.zeros(0, dtype=bool) if followed is None else followed.force >= 0.99 * lowest
        if followed is not None and shown.any():
            values = (MM * np.abs(followed.receptance), followed.frequency, 100 * followed.loss_factor)
            for ax, value in zip(axes, values, strict=True):
                ax.plot(followed.force[shown], value[shown], color=BLUE, label="followed in force")
        for one in peaks:
            fill = VERMILLION if one.complete else "white"
            for ax, at in zip(axes, (MM * one.receptance, one.frequency), strict=False):
                ax.plot(one.force, at, "o", color=VERMILLION, markerfacecolor=fill, markersize=6)
        axes[0].plot([], [], "o", color=VERMILLION, label="peaks of response curves")
        axes[0].set(ylabel="peak receptance [mm/N]", title=f"{mode}: resonance against force")
        from_zero(axes[0])
        axes[1].set(ylabel="frequency [Hz]")
        axes[1].ticklabel_format(axis="y", useOffset=False)
        _not_finer_than_a_test(axes[1])
        axes[2].set(ylabel="loss factor [%]")
        if axes[2].lines:
            from_zero(axes[2])
        for ax in axes:
            force_axis(ax, sorted({one.force for one in peaks}))
        drawing.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _not_finer_than_a_test(ax: Axes) -> None:
    low, high = ax.get_ylim()
    middle = (low + high) / 2
    half = max(high - low, LEAST_SHOWN * middle) / 2
    ax.set_ylim(middle - half, middle + half)
