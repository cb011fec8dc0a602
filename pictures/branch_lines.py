"""A branch as lines: broken where it was not followed, solid where stable, dashed where not, dotted where not known."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability, State
from updamp.pictures.style import GREY

Floats = NDArray[np.float64]

LINES: Mapping[State, Any] = {State.STABLE: "-", State.UNSTABLE: (0, (4, 2)), State.UNKNOWN: (0, (1, 1.2))}
WORDS: Mapping[State, str] = {State.UNSTABLE: "unstable", State.UNKNOWN: "not known if stable"}


def draw_branch(
    ax: Axes, curve: ResponseCurve, size: Floats, colour: Any, stability: BranchStability | None, **style: Any
) -> None:
    """size: (n,) what is drawn over the frequency; without stability all is solid."""
    for start, end, state in _runs(curve, stability):
        ax.plot(curve.frequency[start : end + 1], size[start : end + 1], color=colour, linestyle=LINES[state], **style)


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
