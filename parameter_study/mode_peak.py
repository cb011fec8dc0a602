"""The peak of one mode on a response curve that may hold another mode's too: where the blades move as in the mode."""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from updamp.design.tracked_modes import ModeReference
from updamp.hbm.continuation.response_curve import ResponseCurve

LIKE = 0.5  # modal assurance criterion: a blade that vibrates alone is as much of the one as of the other mode
_PER_POINT = (
    "frequency", "displacement", "response", "work_in", "friction_loss", "material_loss", "iterations", "error",
    "active", "after_gap",
)  # fmt: skip


@dataclass(frozen=True)
class Peak:
    """Largest first harmonic at one point of the rig. frequency: [Hz]; receptance: [m/N]
    place: number of the curve's point at it"""

    frequency: float
    receptance: float
    place: int


def peak_of_mode(curve: ResponseCurve, point: str, reference: ModeReference) -> Peak:
    """Of the whole curve where the blades nowhere move as in the mode."""
    size = np.abs(curve.receptance(point))
    like = likeness(curve, reference) > LIKE
    place = int(np.where(like, size, -1.0).argmax()) if like.any() else int(size.argmax())
    others = np.flatnonzero(~like)
    low = int(others[others < place].max(initial=-1)) + 1 if like.any() else 0
    high = int(others[others > place].min(initial=len(curve))) if like.any() else len(curve)
    frequency, receptance = _part(curve, low, high).peak(point)
    return Peak(frequency, receptance, place)


def likeness(curve: ResponseCurve, reference: ModeReference) -> NDArray[np.float64]:
    """(n,) modal assurance criterion of the first harmonic with the mode's shape, at the blades' points, 0 to 1"""
    points = [point for point in reference.shape if point in curve.points]
    shape = np.array([reference.shape[point] for point in points])
    motion = np.stack([curve.amplitude(point) for point in points], axis=1)
    sizes = (shape @ shape) * np.sum(np.abs(motion) ** 2, axis=1)
    return np.asarray(np.abs(motion @ shape) ** 2 / np.maximum(sizes, np.finfo(float).tiny))


def _part(curve: ResponseCurve, low: int, high: int) -> ResponseCurve:
    assert set(_PER_POINT) <= {f.name for f in fields(curve)}, "names of the curve's columns"
    return replace(curve, **{name: getattr(curve, name)[low:high] for name in _PER_POINT})
