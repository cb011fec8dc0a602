"""Tops of a response that chance does not make.

A top is one if the response falls on both its sides by more than chance makes points differ: its prominence, as
topographers have it. Without that, a bump of the noise on a flank would be a resonance, and the flank's end, which may
be many times as high, would not.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks, peak_prominences
from scipy.stats import norm

from updamp.comparison.fit.failing_model import RISK

Floats = NDArray[np.float64]


def tops(log_size: Floats, deviation: Floats | None = None) -> tuple[NDArray[np.intp], Floats]:
    """Places of the tops between the ends, and their prominences.

    log_size: (n,) logarithms of a response; deviation: (n,) of these, none by default. Of n points there are fewer than
        n^3 / 6 in threes, one between two others, which chance could put so
    """
    places, _ = find_peaks(log_size)
    prominence, left, right = peak_prominences(log_size, places)
    if deviation is not None:
        limit = float(norm.isf(6 * RISK / max(len(log_size), 2) ** 3))
        by_chance = np.hypot(deviation[places], np.maximum(deviation[left], deviation[right]))
        stand = prominence > limit * by_chance
        places, prominence = places[stand], prominence[stand]
    return places, np.asarray(prominence)


def highest(log_size: Floats, deviation: Floats | None = None) -> int:
    """Place of the highest top, at the ends only where there is none inside: there a curve may climb to another mode's
    resonance. As `tops`."""
    inner, _ = tops(log_size, deviation)
    return int(inner[np.argmax(log_size[inner])]) if len(inner) else int(np.argmax(log_size))
