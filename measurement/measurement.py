"""What was measured, in the model's words and units: peak amplitudes in SI, displacement whatever the sensor was.

Complex amplitudes are those of exp(+i w t): a response that lags the force has a negative phase. Of all readers and
formats, this is what the rest of updamp sees; `MeasurementError` is what it gets where data cannot be used.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Where nothing is stated: a steel beam detunes by 1e-4 with half a kelvin; a calibrated sensor is good to a per cent;
# it and a force's control repeat to a thousandth.
DRIFT, GAIN, LEVEL = 1e-4, 0.01, 1e-3
# Relative standard deviation of a single frequency as a generator sets it.
FREQUENCY_ERROR = 2e-6


@dataclass(frozen=True)
class Channel:
    """A sensor. name: as in the data files; point: what it looks at in the model, such as "blade_right.tip.x";
    negative: it was mounted the other way round; the amplitudes of a `MeasuredRun` are turned already
    quantity: that it reads, such as "acceleration"; "" where that is not known
    """

    name: str
    point: str
    negative: bool = False
    quantity: str = ""


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """One sweep: steps of frequency, each settled.

    name: of the run, repeats excepted: runs of one name are repeats of the same test
    mode: of the study, such as "OOP"; upwards: direction of the sweep
    held: what the controller held constant, "force", "response" or "nothing"; level: at which amplitude, in
        level_unit, SI: "N", or that of the channel whose response was held; held_channel: its name, "" if not stated
    repeat: number of the assembly: runs of one number were made without taking the damper out in between
    taken: its number in the order in which these were made, 0 where that is not stated
    channels: names, in the order of `response`
    harmonics: in the order of `response`; 1 is among them
    frequency: (n,) [Hz]; force: (n,) measured amplitude at the excitation [N]
    response: (n_channels, n_harmonics, n) displacement [m]
    noise: (n_channels, n_harmonics, n) stated or estimated standard deviation of its real or imaginary part [m], or
        None where nothing is known of it
    without_phase: channels of which amplitudes alone were recorded: phases in `response` mean nothing
    """

    name: str
    mode: str
    upwards: bool
    held: str
    level: float
    repeat: int
    channels: tuple[str, ...]
    harmonics: tuple[int, ...]
    frequency: Floats
    force: Complex
    response: Complex
    noise: Floats | None = None
    level_unit: str = "N"
    held_channel: str = ""
    without_phase: tuple[str, ...] = ()
    taken: int = 0

    def __len__(self) -> int:
        return len(self.frequency)

    def amplitude(self, channel: str, harmonic: int = 1) -> Complex:
        """(n,) [m]; raises: ValueError naming what there is"""
        if channel not in self.channels or harmonic not in self.harmonics:
            raise ValueError(
                f"run '{self.name}' has no harmonic {harmonic} of channel '{channel}'; it has harmonics "
                f"{self.harmonics} of {', '.join(self.channels)}"
            )
        return np.asarray(self.response[self.channels.index(channel), self.harmonics.index(harmonic)])

    def receptance(self, channel: str) -> Complex:
        """(n,) first harmonic over the measured force [m/N]"""
        return self.amplitude(channel) / self.force


@dataclass(frozen=True)
class Feature:
    """A stated value instead of a curve.

    quantity: "resonance_frequency" or "resonance_frequency_shift"; mode: of the study, or "1F without damper"
    force: [N], nan where it does not matter; value, lower, upper: in SI, nan where not stated
    relative_uncertainty: standard deviation over the value
    """

    quantity: str
    mode: str
    force: float
    value: float
    lower: float
    upper: float
    relative_uncertainty: float


@dataclass(frozen=True, eq=False)
class Measurement:
    """pull: damper load [N]; excitation: point of the model such as "blade_right.excitation.x"

    assumptions: what was not stated and how it was read, in sentences
    hashes: file name -> SHA-256 of what was read
    repeatability: relative standard deviation of a response from test to test as stated, 0 where the repeats tell
    questions: what is hardly meant as it is stated, found when it was held against a model; `stated` has them first
    drift: relative standard deviation of the resonance from run to run of one assembly; gain: of a sensor's gain
    level: of the amplitudes of a whole run from run to run of one assembly
    frequency_error: relative standard deviation of a single frequency
    units: those that responses and force are in where a channel is not calibrated, such as ("V", "N")
    """

    title: str
    pull: float
    excitation: str
    channels: tuple[Channel, ...]
    runs: tuple[MeasuredRun, ...]
    features: tuple[Feature, ...] = ()
    assumptions: tuple[str, ...] = ()
    hashes: Mapping[str, str] | None = None
    repeatability: float = 0.0
    questions: tuple[str, ...] = ()
    drift: float = DRIFT
    gain: float = GAIN
    level: float = LEVEL
    frequency_error: float = FREQUENCY_ERROR
    units: tuple[str, str] = ("m", "N")

    @property
    def calibrated(self) -> bool:
        """Whether a response over a force is one, in units that a model's can be held against."""
        return self.units == ("m", "N")

    @property
    def stated(self) -> tuple[str, ...]:
        """Questions and assumptions: what a reader of the results has to know first."""
        return (*self.questions, *self.assumptions)

    def channel(self, name: str) -> Channel:
        """raises: ValueError naming the channels there are"""
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise ValueError(f"no channel '{name}'; there are {', '.join(c.name for c in self.channels)}")


class MeasurementError(ValueError):
    """Data that cannot be used as they are; the message names the file, the value and the remedy."""


def near(name: str, known: Iterable[str], most: int = 12) -> str:
    """ "did you mean a or b?" where something known comes close, else what there is."""
    names = [name for name in known if name]
    if close := get_close_matches(name, names, n=3, cutoff=0.6):
        return f"did you mean {' or '.join(close)}?"
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"there are {', '.join(names[:most])}{more}" if names else "there are none"
