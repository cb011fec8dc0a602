"""A branch as lines: broken where it was not followed, solid where stable, dashed where not, dotted where not known."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.smooth_branch import smooth_branch
from updamp.hbm.stability.branch_stability import BranchStability, State
from updamp.pictures.style import GREY

MM = 1e3  # m/N to mm/N
HATCH = "////"  # of what was not followed
LINES: Mapping[State, Any] = {State.STABLE: "-", State.UNSTABLE: (0, (4, 2)), State.UNKNOWN: (0, (1, 1.2))}
WORDS: Mapping[State, str] = {State.UNSTABLE: "unstable", State.UNKNOWN: "not known if stable"}


def draw_branch(
    ax: Axes, curve: ResponseCurve, point: str, colour: Any, stability: BranchStability | None, **style: Any
) -> None:
    """Size of the receptance at `point` [mm/N], interpolated; without stability all is solid."""
    smooth = smooth_branch(curve, point)
    size = MM * np.abs(smooth.receptance)
    for start, end, state in _runs(curve, stability):
        places = np.flatnonzero((smooth.interval >= start) & (smooth.interval < end))
        if end < len(curve) - 1 and not curve.after_gap[end + 1]:
            places = np.append(places, places[-1] + 1)  # up to where the next line begins
        ax.plot(smooth.frequency[places], size[places], color=colour, linestyle=LINES[state], **style)


def hatch_gaps(ax: Axes, curve: ResponseCurve, colour: Any) -> None:
    """Hatched: frequencies between which the branch of an incomplete curve was not followed, or where it ends."""
    for one, other in (*curve.gaps(), (curve.frequency[-1],) * 2):
        ax.axvspan(min(one, other), max(one, other), facecolor="none", edgecolor=colour, hatch=HATCH, linewidth=1.0)


def _runs(curve: ResponseCurve, stability: BranchStability | None) -> Iterator[tuple[int, int, State]]:
    """First and last point of each line. Between two points that differ the line is that of the less stable one, and
    not known where one of them is not.
    """
    if len(curve) < 2:
        return
    state = np.full(len(curve), int(State.STABLE)) if stability is None else stability.state
    between = np.maximum(state[1:], state[:-1])
    between[(state[1:] == State.UNKNOWN) | (state[:-1] == State.UNKNOWN)] = State.UNKNOWN
    gaps = curve.after_gap[1:]
    ends = 1 + np.flatnonzero((between[1:] != between[:-1]) | gaps[1:] | gaps[:-1])
    for start, end in pairwise([0, *ends.tolist(), len(between)]):
        if not gaps[start]:
            yield start, end, State(int(between[start]))


def key_of_stability(stability: Mapping[float, BranchStability]) -> list[Artist]:
    """Of the lines that are there."""
    there = [state for state in WORDS if any((one.state == state).any() for one in stability.values())]
    return [Line2D([], [], color=GREY, linestyle=LINES[state], label=WORDS[state]) for state in there]
