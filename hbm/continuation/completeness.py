"""Whether a curve is the whole branch through its window: one definition for tables, pictures and files."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.newton import NewtonOptions

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class CompletenessLimits:
    """What a gap may be at most, for a curve to count as complete.

    window: width, as a share of the window
    half_width: width, as a share of the resonance's half-width (half of the width at the height of 1 / sqrt(2))
    change: of the response across it, relative; across a jump too, for a sweep to show one. Across a tenth of its
        half-width a linear resonance changes by a tenth at most: |d ln H / ds| <= 1 for 1 / (1 + i s), s in
        half-widths
    unsettled: change of the elements' forces by one more cycle of hysteresis, relative: what is told of the curve is
        off by about as much
    still: first harmonic of a point, as a share of the largest response on the curve, that is what Newton's method
        leaves: its maxima are none
    """

    window: float = 0.005
    half_width: float = 0.1
    change: float = 0.1
    unsettled: float = 0.01
    still: float = NewtonOptions.tolerance


def shortcoming(curve: ResponseCurve, window: tuple[float, float], limits: CompletenessLimits, point: str) -> str:
    """Why the curve is not the whole branch through the window [Hz], its resonance as seen at a point within it; ""
    where it is."""
    frequency, after_gap = curve.frequency, curve.after_gap
    if len(frequency) < 2:
        return "no branch was found"
    (low, high), allowed = window, limits.window * (window[1] - window[0])
    for end, reached in ((low, frequency.min()), (high, frequency.max())):
        if abs(min(max(reached, low), high) - end) > allowed:
            return f"the window from {low:.4g} to {high:.4g} Hz is covered to {reached:.6g} Hz only"
    if abs(frequency[-1] - frequency[0]) < (high - low) / 2:
        return f"the branch turned back and left the window where it had entered, at {frequency[-1]:.6g} Hz"
    if curve.stands_still(point, limits.still):
        return f"'{point}' does not move at the frequency of the force: ask for the peak at another point"
    response, size = curve.amplitudes(), np.abs(curve.receptance(point))
    top = int(size.argmax())
    if top in (0, len(size) - 1) or not low <= frequency[top] <= high:
        return _largest_at_an_end(frequency, size, window)
    width, outside = half_width(frequency, size), ""
    for i in np.flatnonzero(after_gap):
        ends = frequency[i - 1 : i + 1]
        apart, change = abs(ends[1] - ends[0]), relative_change(response[i - 1], response[i])
        if not (apart > allowed or apart > limits.half_width * width or change > limits.change):
            continue
        if low <= ends.max() and ends.min() <= high:
            return (
                f"the branch was not followed between {ends[0]:.6g} and {ends[1]:.6g} Hz, where the response changes "
                f"by {change:.0%}"
            )
        outside = _left(low if ends.max() < low else high, (low, high))
    return outside


def _largest_at_an_end(frequency: Floats, size: Floats, window: tuple[float, float]) -> str:
    """The resonance lies beyond that end; or it is another one's flank that stands there."""
    (low, high), at = window, frequency[size.argmax()]
    said = f"the response is largest at {at:.6g} Hz, at or beyond the end of the window from {low:.4g} to {high:.4g} Hz"
    inner = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    inner = inner[(low < frequency[inner]) & (frequency[inner] < high)]
    if not len(inner):
        return (
            f"{said}, so that its resonance does not lie within it: widen the window (damped so heavily that there is "
            "none, no window has it)"
        )
    within = frequency[inner[size[inner].argmax()]]
    remedy = f"{'raise the lower' if abs(at - low) < abs(at - high) else 'lower the upper'} end"
    return (
        f"{said}, and has a maximum at {within:.6g} Hz within it: if that is the resonance meant, {remedy} of the "
        "window until the flank of its neighbour is outside, else widen it"
    )


def _left(end: float, window: tuple[float, float]) -> str:
    """Of a gap beyond an end of the window: nothing of the window is missing there."""
    return (
        f"the branch leaves the window from {window[0]:.4g} to {window[1]:.4g} Hz at {end:.4g} Hz, and it is not known "
        "whether what comes back there is the same branch: widen the window"
    )


def half_width(frequency: Floats, size: Floats, peak: tuple[float, float] | None = None) -> float:
    """Half of the width at the height of 1 / sqrt(2) about the largest value [Hz]; along the branch, so that a
    peak that overhangs has the width of its wider side. Infinite where neither side comes down to that height.

    peak: frequency and size of the largest value, where it is known between the points
    Between the points on both sides of that height the branch is taken as straight.
    """
    top = int(np.argmax(size))
    at, highest = (frequency[top], size[top]) if peak is None else peak
    level = highest / np.sqrt(2)
    below = np.flatnonzero(size < level)
    outside = np.array([*below[below < top][-1:], *below[below > top][:1]], dtype=int)
    inside = outside + np.sign(top - outside)
    share = (level - size[outside]) / (size[inside] - size[outside])
    crossed = frequency[outside] + share * (frequency[inside] - frequency[outside])
    return float(np.abs(crossed - at).max()) if len(crossed) else np.inf


def relative_change(before: Complex, after: Complex) -> float:
    """Of the first harmonics, relative to the larger."""
    largest = max(np.linalg.norm(before), np.linalg.norm(after), np.finfo(float).tiny)
    return float(np.linalg.norm(after - before) / largest)
