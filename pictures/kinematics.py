"""How the damper moves: orbits of its bottom corners, translation and rotation over a period."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.pictures.style import BLUE, DARK_STEEL, GREEN, LIGHT_GREY, ORANGE, VERMILLION, figure
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]

N_TIME = 256
CORNERS = {"left": BLUE, "right": ORANGE}


def damper_motion(curve: ResponseCurve, place: int) -> Mapping[str, Floats]:
    """Bottom corners over one period about their mean, {"left.x": (n_time,), ...} [m]."""
    harmonics = curve.harmonics
    motion = {}
    for side in CORNERS:
        for axis in "xy":
            row = curve.points.index(f"damper.corner_{side}.{axis}")
            coefficients = curve.response[place, row].copy()
            if 0 in harmonics.orders:
                coefficients[harmonics.slices[0]] = 0.0
            motion[f"{side}.{axis}"] = harmonics.synthesis(N_TIME) @ coefficients
    return motion


def corner_positions(rig: Rig) -> Mapping[str, Floats]:
    """(x, y) of the bottom corners [m]."""
    half_width, height = rig.face_bottom
    return {
        side: np.array([sign * half_width, height - rig.damper.base_height])
        for side, sign in (("left", -1), ("right", 1))
    }


def damper_kinematics(path: Path, rig: Rig, curves: Mapping[str, tuple[ResponseCurve, int]]) -> None:
    """One row a mode: the corners' orbits, enlarged, on the damper's section; translation and rotation over a period.

    curves: mode -> curve and the place of its peak
    """
    with figure(path, 10.5, 0.6 + 3.3 * len(curves)) as drawing:
        rows = drawing.subplots(len(curves), 2, squeeze=False)
        for (orbits, histories), (mode, (curve, place)) in zip(rows, curves.items(), strict=True):
            motion = damper_motion(curve, place)
            _orbits(orbits, rig, motion)
            orbits.set_title(
                f"{mode}, {curve.force:g} N, {curve.frequency[place]:.1f} Hz: orbits of the bottom corners"
            )
            histories.set_title("translation of the damper and its rotation")
            _histories(histories, rig, motion, curve.force)


def _orbits(ax: Axes, rig: Rig, motion: Mapping[str, Floats]) -> None:
    outline = _outline(rig)
    ax.fill(*outline, facecolor=LIGHT_GREY, edgecolor=DARK_STEEL)
    largest = max(np.abs(values).max() for values in motion.values())
    enlarged = 0.1 * float(np.ptp(outline[0])) / largest if largest > 0 else 1.0  # in mm a m
    for side, colour in CORNERS.items():
        centre = 1e3 * corner_positions(rig)[side]
        x, y = (centre[i] + enlarged * motion[f"{side}.{axis}"] for i, axis in enumerate("xy"))
        ax.plot(np.append(x, x[0]), np.append(y, y[0]), color=colour)
        ax.plot(x[0], y[0], "o", color=colour, markersize=4)
        ax.annotate(
            "", xy=(x[N_TIME // 8], y[N_TIME // 8]), xytext=(x[N_TIME // 8 - 4], y[N_TIME // 8 - 4]),
            arrowprops={"arrowstyle": "-|>", "color": colour},
        )  # fmt: skip
    ax.set(aspect="equal", xlabel=f"x [mm]   (motion enlarged {enlarged / 1e3:,.0f} times)", ylabel="y [mm]")


def _outline(rig: Rig) -> tuple[Floats, Floats]:
    """Corners of the damper's section (x, y) [mm], counterclockwise from the bottom left."""
    (top, top_height), (bottom, bottom_height), damper = rig.face_top, rig.face_bottom, rig.damper
    right = [(bottom, bottom_height - damper.base_height), (bottom, bottom_height), (top, top_height)]
    if damper.apex_height > 0:
        right.append((damper.apex_flat / 2, top_height + damper.apex_height))
    corners = 1e3 * np.array([*right, *((-x, y) for x, y in reversed(right))])
    return corners[:, 0], corners[:, 1]


def _histories(ax: Axes, rig: Rig, motion: Mapping[str, Floats], force: float) -> None:
    phase = 360 * np.arange(N_TIME) / N_TIME
    span = 2 * corner_positions(rig)["right"][0]
    x, y = ((motion[f"left.{axis}"] + motion[f"right.{axis}"]) / 2 for axis in "xy")
    roll = (motion["right.y"] - motion["left.y"]) / span
    ax.plot(phase, 1e6 * x / force, color=GREEN, label="translation x")
    ax.plot(phase, 1e6 * y / force, color=VERMILLION, label="translation y")
    ax.set(xlabel="phase [degrees]", ylabel="translation over force [µm/N]", xlim=(0, 360), xticks=range(0, 361, 90))
    turned = ax.twinx()
    turned.plot(phase, 1e6 * roll / force, "--", color=BLUE, label="rotation")
    turned.set_ylabel("rotation over force [µrad/N]", color=BLUE)
    turned.grid(visible=False)
    turned.spines["right"].set(visible=True, color=BLUE)
    # To one scale: rotation times half the width moves a corner as much as the translation beside it.
    reach = 1.35e6 / force * max(np.abs(x).max(), np.abs(y).max(), np.abs(roll).max() * span / 2)
    if reach > 0:
        ax.set_ylim(-reach, reach)
        turned.set_ylim(-reach / (span / 2), reach / (span / 2))
    ax.legend(handles=[*ax.lines, *turned.lines], loc="upper right", ncols=3, fontsize=8)
