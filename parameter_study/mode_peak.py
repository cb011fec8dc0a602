"""One mode of a variant: the window it is sought in, and its peak on a response curve that may hold another mode's too,
where the blades move as in the mode."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.design.solved_design import SolvedDesign
from updamp.design.tracked_modes import ModeReference, modal_assurance, tracking_score
from updamp.hbm.continuation.curve_records import COLUMNS
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.small_amplitude import small_amplitude

LIKE = 0.5  # modal assurance criterion: a blade that vibrates alone is as much of the one as of the other mode
SAME = 1e-3  # of the frequency: below that the stuck mode's window holds, and with it curves that are there already


@dataclass(frozen=True)
class Peak:
    """Largest first harmonic at one point of the rig. frequency: [Hz]; receptance: [m/N]
    place: number of the curve's point at it"""

    frequency: float
    receptance: float
    place: int


def window_of_mode(design: SolvedDesign, mode: str) -> tuple[float, float]:
    """[Hz], in proportion to the mode at small amplitude: contacts that are open at rest lower it below the stuck mode.

    raises: what the design's stages raise; UnknownResponseError where the mode is not recognised
    """
    tracked = design.mode(mode)
    (reference,) = (one for one in design.given.references if one.name == mode)
    ratio = _at_small_amplitude(design, reference, tracked.frequency) / tracked.frequency
    if abs(ratio - 1) < SAME:
        return tracked.window
    low, high = tracked.window
    return low * ratio, high * ratio


def _at_small_amplitude(design: SolvedDesign, reference: ModeReference, near: float) -> float:
    """Frequency [Hz] of the mode most like the reference at the blades' points, and close to `near`.

    near: of the stuck mode. It is no higher: contacts that are open at rest only take stiffness away (Courant-Fischer).
    """
    found = small_amplitude(design.model, near)
    shape = np.array(list(reference.shape.values()))
    shapes = found.shapes[[found.free.row(point) for point in reference.shape]]
    score = tracking_score(modal_assurance(shape, shapes), found.frequencies, near)
    softer = found.frequencies <= near * (1 + SAME)
    return float(found.frequencies[np.argmax(np.where(softer, score, -1.0))])


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
    """(n,) of the first harmonic with the mode's shape, at the blades' points, 0 to 1"""
    points = [point for point in reference.shape if point in curve.points]
    shape = np.array([reference.shape[point] for point in points])
    return modal_assurance(shape, np.stack([curve.amplitude(point) for point in points]))


def _part(curve: ResponseCurve, low: int, high: int) -> ResponseCurve:
    return replace(curve, **{name: getattr(curve, name)[low:high] for name in COLUMNS})
