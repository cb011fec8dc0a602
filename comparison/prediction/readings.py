"""A branch as it is read: motion through what the measurement makes of it (`effects/reading.py`)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.derivatives import Change
from updamp.comparison.prediction.held_branch import pairs
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.reading import Reading, SweepPlace

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Moving = tuple[Floats, Floats, Floats]


def as_read(moving: Moving, reading: Reading, changes: Sequence[Change], condition: RunCondition) -> Moving:
    """State (n, m), its derivative along the branch (n, m) and slopes (n, p + 1, m), as `PredictedBranch` has them.

    moving: those of the motion; changes: of the p parameters, each with the reading that it leads to
    """
    if reading == Reading() and all(change.reading == reading for change in changes):
        return moving
    if condition.control is not None:
        reading, changes = (
            _at_one_amplitude(reading),
            [replace(c, reading=_at_one_amplitude(c.reading)) for c in changes],
        )
    state, along, slopes = moving
    log_f, x, force = state[:, 0], amplitudes(state), condition.force
    share, by_log_f = _share(log_f, condition)
    at = SweepPlace(share, 2 * np.pi * np.exp(log_f))
    y, factor = reading.of(x, at, force), reading.by_displacement(at)
    stretch = 1 + reading.drift * by_log_f
    at_frequency = slopes[:, :, :1] * stretch
    of_frequency = factor * reading.compressed(x) * reading.by_log_frequency(at, by_log_f)
    read_slopes = factor[:, None] * reading.compressed_change(x[:, None], amplitudes(slopes))
    read_slopes += of_frequency[:, None] * slopes[:, :, :1]
    for j, change in enumerate(changes):
        read_slopes[:, j] += reading.difference(change.reading, x, at, force) / change.step
        at_frequency[:, j, 0] += (change.reading.drift - reading.drift) * share / change.step
    if condition.control is None:  # else responses are those over the force
        read_slopes[:, -1] += reading.background * force
    read_along = factor * reading.compressed_change(x, amplitudes(along)) + of_frequency * along[:, :1]
    return (
        np.column_stack([log_f + reading.drift * share, pairs(y)]),
        np.column_stack([along[:, 0] * stretch, pairs(read_along)]),
        np.concatenate([at_frequency, pairs(read_slopes)], axis=2),
    )


def _at_one_amplitude(reading: Reading) -> Reading:
    """Where the response is held, what its sensor falls short by is a gain."""
    return replace(reading, compression=0.0)


def amplitudes(values: Floats) -> Complex:
    """(..., n_sensors) of (..., 1 + 2 n_sensors)"""
    return np.asarray(values[..., 1::2] + 1j * values[..., 2::2])


def _share(log_f: Floats, condition: RunCondition) -> tuple[Floats, float]:
    """(n,) of the sweep that is done, and its derivative by the logarithm of the frequency."""
    low, high = np.log(condition.window)
    rate = 1 / (high - low)
    return ((log_f - low) * rate, rate) if condition.upwards else ((high - log_f) * rate, -rate)
