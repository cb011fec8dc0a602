"""Where a mode of a variant lies at small amplitude: contacts that are open at rest lower it below the stuck mode."""

import numpy as np

from updamp.design.solved_design import SolvedDesign
from updamp.design.tracked_modes import ModeReference
from updamp.model.small_amplitude import small_amplitude

SAME = 1e-3  # of the frequency: below that the stuck mode's window holds, and with it curves that are there already


def window_of_mode(design: SolvedDesign, mode: str) -> tuple[float, float]:
    """[Hz], in proportion to the mode at small amplitude

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
    """Frequency [Hz] of the mode most like the reference at the blades' points, and close to `near`."""
    found = small_amplitude(design.model, near)
    shape = np.array(list(reference.shape.values()))
    shapes = found.shapes[[found.free.row(point) for point in reference.shape]]
    sizes = (shape @ shape) * np.sum(np.abs(shapes) ** 2, axis=0)
    likeness = np.abs(shape @ shapes) ** 2 / np.maximum(sizes, np.finfo(float).tiny)
    apart = np.abs(np.log(np.maximum(found.frequencies, 1e-9) / near))
    return float(found.frequencies[np.argmax(likeness * np.exp(-apart))])
