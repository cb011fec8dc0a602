"""How the damper moves: orbits of its bottom corners, translation and rotation over a period."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.pictures.damper_section import corner_positions, draw_section, outline
from updamp.pictures.style import BLUE, GREEN, ORANGE, VERMILLION, figure
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]

N_TIME = 256
REACH = 0.1  # of the damper's width: the largest motion as it is drawn
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


def damper_kinematics(path: Path, rig: Rig, curves: Sequence[tuple[ResponseCurve, int]]) -> None:
    """One row each: the corners' orbits, enlarged, on the damper's section; translation and rotation over a period.

    curves: with the places of their peaks
    """
    with figure(path, 10.5, 0.6 + 2.5 * len(curves)) as drawing:
        rows = drawing.subplots(len(curves), 2, squeeze=False, width_ratios=[1.1, 1.0])
        for number, ((orbits, histories), (curve, place)) in enumerate(zip(rows, curves, strict=True)):
            motion = damper_motion(curve, place)
            enlarged = _orbits(orbits, rig, motion)
            at = f"{curve.mode}, {curve.force:g} N, {curve.frequency[place]:.1f} Hz"
            orbits.set_title(f"{at}: motion of the corners, {enlarged:,.0f} times")
            if number == 0:
                histories.set_title("translation and rotation over a period")
            _histories(histories, rig, motion, curve.force)
            if number == 0:
                lines = [*histories.lines, *drawing.axes[-1].lines]
        drawing.legend(handles=lines, loc="outside lower right", ncols=3)


def _orbits(ax: Axes, rig: Rig, motion: Mapping[str, Floats]) -> float:
    """Of the bottom corners. returns: how many times the motion is enlarged"""
    draw_section(ax, rig)
    x, y = outline(rig)
    largest = max(np.abs(values).max() for values in motion.values())
    reach = REACH * float(np.ptp(x))
    enlarged = two_digits(reach / largest) if largest > 0 else 1e3  # in mm a m
    for side, colour in CORNERS.items():
        centre = 1e3 * corner_positions(rig)[side]
        over, up = (centre[i] + enlarged * motion[f"{side}.{axis}"] for i, axis in enumerate("xy"))
        ax.plot(np.append(over, over[0]), np.append(up, up[0]), color=colour)
        ax.plot(over[0], up[0], "o", color=colour, markersize=4)
        ax.annotate(
            "", xy=(over[N_TIME // 8], up[N_TIME // 8]), xytext=(over[N_TIME // 8 - 4], up[N_TIME // 8 - 4]),
            arrowprops={"arrowstyle": "-|>", "color": colour},
        )  # fmt: skip
    ax.set(xlim=(x.min() - 1.2 * reach, x.max() + 1.2 * reach), ylim=(y.min() - 1.2 * reach, y.max() + 0.3 * reach))
    return enlarged / 1e3


def two_digits(value: float) -> float:
    """The largest number of two digits, and zeros, that is not larger."""
    last = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.floor(value / last) * last)


def _histories(ax: Axes, rig: Rig, motion: Mapping[str, Floats], force: float) -> None:
    phase = 360 * np.arange(N_TIME) / N_TIME
    span = 2 * corner_positions(rig)["right"][0]
    x, y = ((motion[f"left.{axis}"] + motion[f"right.{axis}"]) / 2 for axis in "xy")
    roll = (motion["right.y"] - motion["left.y"]) / span
    ax.plot(phase, 1e6 * x / force, color=GREEN, label="translation x")
    ax.plot(phase, 1e6 * y / force, color=VERMILLION, label="translation y")
    ax.set(xlabel="phase [degrees]", ylabel="translation [µm/N]", xlim=(0, 360), xticks=range(0, 361, 90))
    turned = ax.twinx()
    turned.plot(phase, 1e6 * roll / force, "--", color=BLUE, label="rotation")
    turned.set_ylabel("rotation [µrad/N]", color=BLUE)
    turned.grid(visible=False)
    turned.spines["right"].set(visible=True, color=BLUE)
    # To one scale: rotation times half the width moves a corner as much as the translation beside it.
    reach = 1.35e6 / force * max(np.abs(x).max(), np.abs(y).max(), np.abs(roll).max() * span / 2)
    if reach > 0:
        ax.set_ylim(-reach, reach)
        turned.set_ylim(-reach / (span / 2), reach / (span / 2))
