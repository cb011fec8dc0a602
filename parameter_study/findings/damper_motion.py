"""Findings about how the damper moves: translation and rolling, and its mean position near a resonance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured
from updamp.parameter_study.findings.pesaresi_names import HIGHEST, IP, LOWEST, OOP, film
from updamp.parameter_study.solved_study import SolvedStudy

PURE = 0.1  # rotation's part of the corners' motion, for it to be a translation
ANTIPHASE = 30.0  # degrees within which corners count as in antiphase
NEAR_RESONANCE = 2.0  # the mean position at the resonance over the largest at the ends of the window


@dataclass(frozen=True)
class CornerMotion:
    """rotation: over translation, largest displacements of a corner; phase: between the corners' vertical motions, 0 to
    180 [degrees]"""

    rotation: float
    phase: float


def corner_motion(solved: SolvedStudy, name: CurveName) -> CornerMotion:
    """First harmonic of the bottom corners at the peak. raises: UnknownResultError"""
    curve = solved.curve(name)
    i = solved.peak_of(name, curve).place
    corner = {
        side: np.array([curve.amplitude(f"damper.corner_{side}.{axis}")[i] for axis in "xy"])
        for side in ("left", "right")
    }
    translation = (corner["left"] + corner["right"]) / 2
    rotation = (corner["right"] - corner["left"]) / 2
    phase = abs(np.degrees(np.angle(corner["right"][1] / corner["left"][1])))
    return CornerMotion(float(np.linalg.norm(rotation) / np.linalg.norm(translation)), float(phase))


def translates_in_oop_rolls_in_ip(solved: SolvedStudy) -> Measured:
    oop, ip = (corner_motion(solved, film(mode, LOWEST)) for mode in (OOP, IP))
    return Measured(
        f"rotation over translation at the bottom corners: OOP {oop.rotation:.2f}, IP {ip.rotation:.2f}; corners in IP "
        f"{ip.phase:.0f} degrees apart",
        oop.rotation < PURE and abs(180 - ip.phase) <= ANTIPHASE,
        {"OOP rotation over translation": oop.rotation, "IP corners apart [degrees]": ip.phase},
    )


def mean_lift(curve: ResponseCurve) -> NDArray[np.float64]:
    """(n,) mean position of the damper's bottom corners, up [m]"""
    up = [curve.amplitude(f"damper.corner_{side}.y", 0).real for side in ("left", "right")]
    return np.asarray(sum(up) / 2)


def mean_opening(curve: ResponseCurve) -> NDArray[np.float64]:
    """(n,) by how much the platforms' mean positions are further apart [m]"""
    right, left = (curve.amplitude(f"blade_{side}.platform.x", 0).real for side in ("right", "left"))
    return np.asarray(right - left)


def mean_position_moves(solved: SolvedStudy) -> Measured:
    curve = solved.curve(film(IP, HIGHEST))
    i = solved.peak_of(film(IP, HIGHEST), curve).place
    numbers, met = {}, True
    for name, value in (("damper up", mean_lift(curve)), ("blades apart", mean_opening(curve))):
        at_ends = max(abs(value[0]), abs(value[-1]))
        numbers[f"{name} [um]"], numbers[f"{name}, ends of the window [um]"] = 1e6 * value[i], 1e6 * at_ends
        met = met and value[i] > NEAR_RESONANCE * at_ends
    words = ", ".join(f"{name} {value:.3g}" for name, value in numbers.items())
    return Measured(f"IP at 17 N, at the resonance: {words}", bool(met), numbers)
