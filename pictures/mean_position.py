"""How the mean position of damper and blades moves along a response curve."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.pictures.style import figure, shades

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MeanPosition:
    """frequency: (n,) [Hz]; lift: (n,) of the damper, up [m]; opening: (n,) of the platforms, apart [m]
    peak: number of the point at the resonance"""

    frequency: Floats
    lift: Floats
    opening: Floats
    peak: int


def mean_positions(path: Path, title: str, curves: Mapping[float, MeanPosition]) -> None:
    """curves: by force [N]; dots at the resonances"""
    forces: Sequence[float] = sorted(curves)
    with figure(path, 10.0, 4.2) as drawing:
        lift, opening = drawing.subplots(1, 2, sharex=True)
        for force, colour in zip(forces, shades(len(forces)), strict=True):
            one = curves[force]
            for ax, value in ((lift, one.lift), (opening, one.opening)):
                ax.plot(one.frequency, 1e6 * value, color=colour, label=f"{force:g} N")
                ax.plot(one.frequency[one.peak], 1e6 * value[one.peak], "o", color=colour, markersize=5)
                ax.set_xlabel("frequency [Hz]")
                ax.margins(x=0)
        lift.set(ylabel="mean position [µm]", title=f"{title}: damper, up")
        opening.set(title="platforms, apart")
        drawing.legend(*lift.get_legend_handles_labels(), loc="outside right upper", fontsize=8.5)
