"""What a data file holds, before anything is converted: its own units, signs, names and peak or RMS values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


def complex_of(real: Floats, imaginary: Floats) -> Complex:
    """Without arithmetic, so that an infinite part stays as the file has it."""
    value = real.astype(np.complex128)
    value.imag = imaginary
    return value


@dataclass(frozen=True, eq=False)
class RecordedChannel:
    """One sensor in one sweep.

    amplitude: (n_harmonics, n) complex, in the unit of the file; harmonics: their numbers
    noise: (n_harmonics, n) standard deviation of the real or imaginary part, in the same unit; None where not known
    per_force: the amplitude is a frequency response function: divided by the force of the same sweep
    unit, quantity, direction: what the file itself says, such as "mm/s", "velocity", "-X"; "" where it says nothing
    """

    amplitude: Complex
    harmonics: tuple[int, ...] = (1,)
    noise: Floats | None = None
    per_force: bool = False
    unit: str = ""
    quantity: str = ""
    direction: str = ""


@dataclass(frozen=True, eq=False)
class RecordedSweep:
    """One sweep of all its channels over common frequencies.

    run, sweep: as the file labels them ("" where it does not); sweep: "up" or "down"
    repeat: number of the assembly, None where the file has none
    frequency: (n,) [Hz] in the order of the file
    others: channels of the file that were not asked for
    notes: what the reader took for granted, in sentences
    """

    run: str
    repeat: int | None
    sweep: str
    frequency: Floats
    channels: Mapping[str, RecordedChannel]
    others: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def one_way(sweep: RecordedSweep) -> tuple[RecordedSweep, ...]:
    """The sweep; as one up and one down where the file does not tell them apart and the frequency turns round once,
    with the point where it does in the first of them."""
    steps = np.sign(np.diff(sweep.frequency))
    turns = np.flatnonzero(steps[1:] != steps[:-1]) + 1
    if sweep.sweep or len(turns) != 1:
        return (sweep,)
    end = int(turns[0]) + 1
    directions = ("up", "down") if steps[0] > 0 else ("down", "up")
    return tuple(_part(sweep, rows, d) for rows, d in zip((slice(end), slice(end, None)), directions, strict=True))


def _part(sweep: RecordedSweep, rows: slice, direction: str) -> RecordedSweep:
    channels = {
        name: replace(c, amplitude=c.amplitude[:, rows], noise=None if c.noise is None else c.noise[:, rows])
        for name, c in sweep.channels.items()
    }
    return replace(sweep, sweep=direction, frequency=sweep.frequency[rows], channels=channels)
