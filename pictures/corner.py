"""A posterior as it is usually shown: each quantity by itself on the diagonal, each pair of them below it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from updamp.pictures.style import BLUE, LIGHT_GREY, SEQUENTIAL, figure

BINS = 24
_INCHES = 0.95  # of one panel


@dataclass(frozen=True, eq=False)
class Drawn:
    """One quantity. values: (n,) equally probable; bounds: of the prior, which is even between them"""

    label: str
    values: NDArray[np.float64]
    bounds: tuple[float, float]


def corner(path: Path, drawn: Sequence[Drawn]) -> None:
    """PNG, SVG and PDF. On the diagonal the prior is the grey line."""
    n = len(drawn)
    with figure(path, _INCHES * n + 0.8, _INCHES * n + 0.6) as drawing:
        panels = drawing.subplots(n, n, squeeze=False)
        for row, up in enumerate(drawn):
            for column, along in enumerate(drawn):
                axes = panels[row][column]
                if column > row:
                    axes.set_visible(False)
                    continue
                _alone(axes, along) if column == row else _pair(axes, along, up)
                _label(axes, along.label if row == n - 1 else "", up.label if column == 0 < row else "")


def _alone(axes: Axes, one: Drawn) -> None:
    axes.hist(one.values, bins=BINS, range=one.bounds, density=True, color=BLUE, linewidth=0)
    axes.axhline(1 / (one.bounds[1] - one.bounds[0]), color=LIGHT_GREY)
    axes.set_xlim(*one.bounds)
    axes.set_yticks([])


def _pair(axes: Axes, along: Drawn, up: Drawn) -> None:
    counts, x, y = np.histogram2d(along.values, up.values, BINS, [along.bounds, up.bounds])
    axes.pcolormesh(x, y, np.ma.masked_equal(counts.T, 0), cmap=SEQUENTIAL, rasterized=True)
    axes.set(xlim=along.bounds, ylim=up.bounds)


def _label(axes: Axes, below: str, left: str) -> None:
    axes.tick_params(labelsize=6, labelbottom=bool(below), labelleft=bool(left))
    axes.grid(visible=False)
    axes.set_xlabel(below, fontsize=7)
    axes.set_ylabel(left, fontsize=7)


def drawn_of(
    draws: Mapping[str, NDArray[np.float64]], units: Mapping[str, str], bounds: Mapping[str, tuple[float, float]]
) -> list[Drawn]:
    """By the names of the quantities."""
    labels = {name: f"{name} [{units[name]}]" if units[name] else name for name in draws}
    return [Drawn(labels[name], values, bounds[name]) for name, values in draws.items()]
