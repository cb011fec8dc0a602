"""Points at which a sensor or its amplifier was overloaded: the top of a curve is cut off at one value."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.recorded import Floats, RecordedChannel, RecordedSweep

LEAST = 3  # points of one value: two next to each other may be a top between them
_DIGITS = 12  # more are those of the arithmetic on the way


def without_overload(where: str, sweep: RecordedSweep, labels: Mapping[str, str]) -> tuple[RecordedSweep, list[str]]:
    """The sweep without the points at which one of the channels was overloaded, and a sentence on each. labels: of the
    channels, by their names"""
    present = {name: sweep.channels[label] for name, label in labels.items() if label in sweep.channels}
    cut = {name: points for name, channel in present.items() if (points := overloaded(channel)).any()}
    if not cut:
        return sweep, []
    kept = ~np.any(list(cut.values()), axis=0)
    channels = {label: _only(channel, kept) for label, channel in sweep.channels.items()}
    notes = [_told(f"{where} channel '{name}'", sweep.frequency[points]) for name, points in cut.items()]
    return replace(sweep, frequency=sweep.frequency[kept], channels=channels), notes


def overloaded(channel: RecordedChannel) -> NDArray[np.bool_]:
    """(n,) whether the amplitude of the first harmonic stays at its highest value, and cuts off what comes before.

    Rounded to a resolution r a top of k equal values falls by up to r within them, so by no more than
    r ((k + 1) / (k - 1))^2 to the points next to them if it is a parabola, and one r more by rounding. Where both of
    these fall by more, it is no top.
    """
    first = channel.amplitude[[k == 1 for k in channel.harmonics]].sum(axis=0)
    size = np.abs(first)
    found = np.zeros(len(size), dtype=bool)
    if not (np.isfinite(size).all() and size.any()):
        return found
    of_parts = 2 * max(_resolution(part) for part in (first.real, first.imag)) if channel.has_phase else 0.0
    blurred = max(of_parts, 10.0**-_DIGITS * size.max())
    same = size >= size.max() - blurred
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]])))
    for begin, end in edges.reshape(-1, 2):
        k = int(end - begin)
        beside = size[[i for i in (begin - 1, end) if 0 <= i < len(size)]]
        read_once = channel.has_phase and bool(np.all(first[begin:end] == first[begin]))
        if k >= LEAST and len(beside) and not read_once:
            most = (_resolution(size) + blurred) * (((k + 1) / (k - 1)) ** 2 + 1)
            found[begin:end] = (size.max() - beside > most).all()
    return found


def _resolution(values: Floats) -> float:
    """Of the largest of some values, with as many digits as any of them has."""
    size = np.abs(values[values != 0])
    if not len(size):
        return 0.0
    exponent = np.floor(np.log10(size))
    for digits in range(1, _DIGITS + 1):
        unit = 10.0 ** (exponent - digits + 1)
        if np.allclose(np.round(size / unit) * unit, size, rtol=10.0**-_DIGITS, atol=0.0):
            break
    return float(10.0 ** (exponent.max() - digits + 1))


def _only(channel: RecordedChannel, kept: NDArray[np.bool_]) -> RecordedChannel:
    noise = None if channel.noise is None else channel.noise[:, kept]
    return replace(channel, amplitude=channel.amplitude[:, kept], noise=noise)


def _told(where: str, frequency: Floats) -> str:
    return (
        f"{where}: its {len(frequency)} highest values, {frequency.min():g} to {frequency.max():g} Hz, are one and the "
        "same, as where a sensor or its amplifier is overloaded; these points are left out"
    )
