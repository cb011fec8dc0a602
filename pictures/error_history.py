"""How the error fell with each effect: a waterfall from the baseline down to what repeats alone give."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from updamp.pictures.style import BLUE, GREEN, GREY, INK, ORANGE, VERMILLION, figure


@dataclass(frozen=True)
class Fall:
    """One step of one error. name: as it is called below its bar; before, after: weighted residual RMS, nan where not
    known; compared: errors that comparisons with this model obtained; floor: of repeats, nan where not known"""

    name: str
    before: float
    after: float
    compared: tuple[float, ...] = ()
    floor: float = nan


def error_waterfall(path: Path, title: str, panels: Sequence[tuple[str, Sequence[Fall]]]) -> None:
    """One panel for each kind of error, named; a panel of which nothing is known says so."""
    steps = max(len(falls) for _, falls in panels)
    with figure(path, max(9.0, 2.6 * (steps + 1)), 4.4) as drawing:
        drawing.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
        for ax, (name, falls) in zip(drawing.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            ax.set_title(name)
            _panel(ax, falls)
        marks = [Line2D([], [], linestyle="--", color=GREY, label="repeats alone")]
        if any(fall.compared for _, falls in panels for fall in falls):
            marks.append(Line2D([], [], linestyle="", marker="D", color=ORANGE, label="obtained by updamp compare"))
        drawing.legend(handles=marks, loc="outside lower center", ncols=2)


def _panel(ax: Axes, falls: Sequence[Fall]) -> None:
    if not any(isfinite(x) for fall in falls for x in (fall.before, fall.after, *fall.compared)):
        ax.text(0.5, 0.5, "not known", transform=ax.transAxes, ha="center", color=GREY)
        ax.set_axis_off()
        return
    start = falls[0].before
    if isfinite(start):
        ax.bar(0, start, color=BLUE, width=0.6)
        _label(ax, 0, start, f"{start:.3g}")
    for i, fall in enumerate(falls, start=1):
        _bar(ax, i, fall)
    ax.set_xticks(range(len(falls) + 1), ["before", *(fall.name.replace(", ", "\n") for fall in falls)])
    ax.tick_params(axis="x", labelrotation=0 if len(falls) < 4 else 20)
    ax.grid(visible=False, axis="x")
    ax.set_ylabel("weighted residual RMS")
    ax.set_ylim(bottom=0)
    ax.margins(y=0.12)


def _bar(ax: Axes, place: int, fall: Fall) -> None:
    if isfinite(fall.before) and isfinite(fall.after):
        ax.plot([place - 0.7, place + 0.3], [fall.before, fall.before], color=GREY, linewidth=0.8)
        colour = GREEN if fall.after <= fall.before else VERMILLION
        ax.bar(place, fall.before - fall.after, bottom=fall.after, color=colour, width=0.6)
        _label(ax, place, fall.after, f"{fall.after:.3g}", below=fall.after <= fall.before)
    elif isfinite(fall.after):
        ax.plot([place - 0.3, place + 0.3], [fall.after, fall.after], color=BLUE)
        _label(ax, place, fall.after, f"{fall.after:.3g}")
    if isfinite(fall.floor):
        ax.plot([place - 0.5, place + 0.5], [fall.floor, fall.floor], "--", color=GREY)
    ax.plot([place] * len(fall.compared), fall.compared, "D", color=ORANGE, markeredgecolor=INK, markersize=6)


def _label(ax: Axes, place: float, height: float, text: str, below: bool = False) -> None:
    shift, side = (-3, "top") if below else (3, "bottom")
    box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
    ax.annotate(
        text, (place, height), textcoords="offset points", xytext=(0, shift), ha="center", va=side, bbox=box, zorder=4
    )
