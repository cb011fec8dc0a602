"""The damper's section, as pictures draw it: its outline, its corners, its two faces."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from updamp.pictures.style import DARK_STEEL, LEFT_FACE, LIGHT_GREY, RIGHT_FACE
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def corner_positions(rig: Rig) -> Mapping[str, Floats]:
    """(x, y) of the bottom corners [m]."""
    half_width, height = rig.face_bottom
    return {
        side: np.array([sign * half_width, height - rig.damper.base_height])
        for side, sign in (("left", -1), ("right", 1))
    }


def outline(rig: Rig) -> tuple[Floats, Floats]:
    """Corners of the section (x, y) [mm], counterclockwise from the bottom left."""
    (top, top_height), (bottom, bottom_height), damper = rig.face_top, rig.face_bottom, rig.damper
    right = [(bottom, bottom_height - damper.base_height), (bottom, bottom_height), (top, top_height)]
    if damper.apex_height > 0:
        right.append((damper.apex_flat / 2, top_height + damper.apex_height))
    corners = 1e3 * np.array([*right, *((-x, y) for x, y in reversed(right))])
    return corners[:, 0], corners[:, 1]


def draw_section(ax: Axes, rig: Rig) -> None:
    """To scale [mm]"""
    ax.fill(*outline(rig), facecolor=LIGHT_GREY, edgecolor=DARK_STEEL)
    ax.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")


def draw_faces(ax: Axes, rig: Rig) -> None:
    """The section without scales, its faces named and coloured."""
    ax.fill(*outline(rig), facecolor=LIGHT_GREY, edgecolor=DARK_STEEL)
    (top, top_height), (bottom, bottom_height) = (1e3 * np.asarray(end) for end in (rig.face_top, rig.face_bottom))
    for sign, colour, name, side in ((-1, LEFT_FACE, "left", "right"), (1, RIGHT_FACE, "right", "left")):
        ax.plot([sign * bottom, sign * top], [bottom_height, top_height], color=colour, linewidth=4.0)
        middle = sign * (bottom + top) / 2, (bottom_height + top_height) / 2
        ax.annotate(f" {name} ", middle, (sign * 4, 4), textcoords="offset points", ha=side, va="bottom", fontsize=8)
    ax.set(aspect="equal")
    ax.margins(x=0.3, y=0.4)
    ax.set_axis_off()
