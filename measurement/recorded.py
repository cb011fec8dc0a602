"""What a data file holds, before anything is converted: its own units, signs, names and peak or RMS values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAME = 0.1  # of a step: frequencies closer than that were one as commanded; fits of time signals part them by less


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
    per_force: whether the amplitude is a frequency response function, divided by the force of the same sweep; None
        where the file does not say
    unit, quantity, direction: what the file itself says, such as "mm/s", "velocity", "-X"; "" where it says nothing; of
        a frequency response function the response's
    """

    amplitude: Complex
    harmonics: tuple[int, ...] = (1,)
    noise: Floats | None = None
    per_force: bool | None = None
    unit: str = ""
    quantity: str = ""
    direction: str = ""

    @property
    def has_phase(self) -> bool:
        """Whether any value of the first harmonic is not real, as near a resonance it is; where there is no first
        harmonic, or nothing but zeros, nothing is known against it."""
        first = self.amplitude[[k == 1 for k in self.harmonics]]
        return bool(not first.any() or first.imag.any())


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
    with the point where it does in the first of them, or one in each where it was recorded twice."""
    change = np.diff(sweep.frequency)
    steps = np.sign(change)
    moving = np.flatnonzero(steps)
    back = moving[1:][steps[moving[1:]] != steps[moving[:-1]]]  # first step after a turn
    if sweep.sweep or len(back) != 1 or not np.isfinite(change).all():
        return (sweep,)
    twice = abs(change[back[0] - 1]) < SAME * abs(change[back[0]])
    end = int(back[0]) + (0 if twice else 1)
    directions = ("up", "down") if steps[moving[0]] > 0 else ("down", "up")
    return tuple(_part(sweep, rows, d) for rows, d in zip((slice(end), slice(end, None)), directions, strict=True))


def _part(sweep: RecordedSweep, rows: slice, direction: str) -> RecordedSweep:
    channels = {
        name: replace(c, amplitude=c.amplitude[:, rows], noise=None if c.noise is None else c.noise[:, rows])
        for name, c in sweep.channels.items()
    }
    return replace(sweep, sweep=direction, frequency=sweep.frequency[rows], channels=channels)
