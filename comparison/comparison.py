"""What a comparison of model and measurement hands on: numbers for `comparison.json`, the report and the diagnosis."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.json_document import JsonDocument

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Key of the provenance: probability of a misfit as large by chance.
LACK_OF_FIT = "lack of fit"
# Before questions on what is stated, which stand before all else.
ASKED_FIRST = "answer this first: calibration and searches make up for it, and what they find may be nothing else"
MOVED_BY_NUMERICS = "finer numerics move frequencies by up to"
FAR = 2.0  # prior standard deviations, from where on a calibrated value deserves a word: 1 in 20 by chance


@dataclass(frozen=True)
class Finding:
    """One sentence on where the model fails.

    mode: of the study, "" for all; level: at which it holds, None for every level
    quantity: "frequency", "damping", "amplitude", "sensor" or "phase"; channel: for a sensor, else ""
    relative: model over measurement less 1, of a phase the measured lag [rad]; significance: in standard deviations of
        the scatter
    """

    text: str
    mode: str
    level: float | None
    quantity: str
    channel: str
    relative: float
    significance: float


@dataclass(frozen=True)
class UnlikeRun:
    """One of the repeats of a test that differs from the others by more than they do among each other.

    run: name of the test; level: with its unit; repeat: number of the assembly; times: how many times their scatter it
    is away from their mean; chance: probability of as much by chance
    """

    run: str
    mode: str
    level: str
    repeat: int
    times: float
    chance: float

    @property
    def text(self) -> str:
        return (
            f"{self.mode} at {self.level}, repeat {self.repeat}: unlike its repeats, {self.times:.1f} times as far "
            "from them as they are from each other; look at this run, or leave it out"
        )


FORCE = "the force"  # in the place of a channel


@dataclass(frozen=True)
class OddPoint:
    """A point of a run that is unlike the points next to it.

    run, mode, level, repeat: as of an `UnlikeRun`; channel: its name, or `FORCE`; frequency: [Hz]; relative: of the
    amplitude, degrees: of the phase, whichever is odd, the other nan; chance: probability of as much by chance
    """

    run: str
    mode: str
    level: str
    repeat: int
    channel: str
    frequency: float
    relative: float
    degrees: float
    chance: float

    @property
    def text(self) -> str:
        if not np.isnan(self.relative):
            side = "high" if self.relative > 0 else "low"
            beside = "" if self.channel == FORCE else " for the force there,"
            size = f"{_two_digits(100 * abs(self.relative))} % {side}{beside}"
        else:
            size = f"{_two_digits(abs(self.degrees))} degrees {'early' if self.degrees > 0 else 'late'}"
        return (
            f"{self.mode} at {self.level}, repeat {self.repeat}: {self.channel} at {self.frequency:.6g} Hz reads "
            f"{size} beside the points next to it, and is left out of calibration and findings; look at this point"
        )


def _two_digits(value: float) -> str:
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """One repeat of a run at one channel. frequency: (n,) [Hz]; receptance: (n,) [m/N]; force: (n,) [N]
    has_phase: whether a phase was recorded; if not, that of `receptance` means nothing"""

    repeat: int
    frequency: Floats
    receptance: Complex
    force: Floats
    has_phase: bool = True


@dataclass(frozen=True, eq=False)
class ModelCurve:
    """The whole branch, turning points and all, at the run's nominal level. frequency [Hz], receptance [m/N]: (n,)

    visited: (n,) whether a slow sweep in the run's direction sees the point
    """

    frequency: Floats
    receptance: Complex
    visited: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class CurvePair:
    """One run (all repeats) at one channel.

    band: (n, 3) frequency [Hz], lower and upper end of 95 % of what a repeat gives in |receptance| [m/N]
    before, after: model at the rig file's values, and calibrated
    frac, csac, csf: secondary numbers, after calibration
    """

    run: str
    mode: str
    level: float
    upwards: bool
    channel: str
    measured: tuple[MeasuredCurve, ...]
    band: Floats
    before: ModelCurve
    after: ModelCurve
    frac: float
    csac: float
    csf: float


@dataclass(frozen=True, eq=False)
class PointResidual:
    """Of one measured point after calibration, in standard deviations: amplitude (measured above the model: positive),
    phase, and `size`, both together (1 is what scatter gives)."""

    run: str
    mode: str
    level: float
    repeat: int
    channel: str
    frequency: float
    amplitude: float
    phase: float
    size: float


@dataclass(frozen=True, eq=False)
class Backbone:
    """Resonance against amplitude, one entry a level (and repeat, where measured).

    amplitude: displacement at the channel [m]; frequency [Hz]; damping: equivalent loss factor [-]; receptance [m/N]
    """

    mode: str
    channel: str
    level: Floats
    repeat: NDArray[np.int64]
    amplitude: Floats
    frequency: Floats
    damping: Floats
    receptance: Floats


@dataclass(frozen=True)
class Calibrated:
    """A nuisance parameter. before: the rig file's; prior_deviation: relative; after, lower, upper: with 95 % interval;
    all in `unit`"""

    name: str
    unit: str
    before: float
    prior_deviation: float
    after: float
    lower: float
    upper: float

    @property
    def deviations(self) -> float:
        """Prior standard deviations that calibration has moved it by; nan where it has none."""
        deviation = abs(self.before) * self.prior_deviation
        return (self.after - self.before) / deviation if deviation > 0 else math.nan

    @property
    def far(self) -> bool:
        """Whether it deserves a word."""
        return abs(self.deviations) > FAR


@dataclass(frozen=True)
class FeatureComparison:
    """A stated value against the model's: all in SI, nan where there is none

    relative: model over measured less 1; relative_uncertainty: standard deviation of the stated value over it
    """

    quantity: str
    mode: str
    force: float
    measured: float
    lower: float
    upper: float
    model: float
    relative: float
    relative_uncertainty: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """chi2_before, chi2_after: chi-square, weighted sums of squares; values: number of real values; parameters: fitted

    adequate: whether nothing stands out of the scatter; provenance: what made it (rig, hashes, versions), in words
    level_unit: of every `level`: that of the force, or SI unit of the response that was held
    response_unit, force_unit: "m" and "N", or what stands for them where channels are not calibrated
    contact_states: for each curve's name "OOP 17 N": share of contacts stuck, slipping, separating, open at the peak
    unlike_repeats, odd_points: runs and points that are to be looked at, whatever the model does; checks: what else is
    questions: what is hardly meant as it is stated: to be answered before anything here is believed
    calibrated_modes: of a rig given by several modes, what the factors on all modes and on each are together
    """

    title: str
    adequate: bool
    findings: tuple[Finding, ...]
    calibration: tuple[Calibrated, ...]
    curves: tuple[CurvePair, ...]
    residuals: tuple[PointResidual, ...]
    measured_backbones: tuple[Backbone, ...]
    model_backbones: tuple[Backbone, ...]
    features: tuple[FeatureComparison, ...]
    scatter: Mapping[str, float]
    chi2_before: float
    chi2_after: float
    values: int
    parameters: int
    contact_states: Mapping[str, tuple[float, float, float, float]]
    assumptions: tuple[str, ...]
    provenance: Mapping[str, str]
    level_unit: str = "N"
    response_unit: str = "m"
    force_unit: str = "N"
    unlike_repeats: tuple[UnlikeRun, ...] = ()
    odd_points: tuple[OddPoint, ...] = ()
    calibrated_modes: tuple[Calibrated, ...] = ()
    questions: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()

    @property
    def to_look_at(self) -> tuple[str, ...]:
        """In words."""
        return (*(run.text for run in self.unlike_repeats), *(point.text for point in self.odd_points), *self.checks)


# `comparison.json`, every number kept to the last digit: the fields of `Comparison` by their names, and `schema`;
# complex as {"re", "im"}, nan as null.
COMPARISON_JSON = JsonDocument(Comparison, "updamp comparison 4", "updamp compare")
