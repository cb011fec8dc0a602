"""What a diagnosis hands on: the content of `diagnosis.json`, for the report, `updamp add` and the benchmark.

Effects go by their names in the catalogue. Residuals are in standard deviations of the scatter that repeats show.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Calibrated
from updamp.comparison.json_document import JsonDocument

Floats = NDArray[np.float64]
Outcome = Literal["adequate", "identified", "inseparable", "unknown", "undecidable"]


@dataclass(frozen=True)
class FittedParameter:
    """Of an effect. value: with 95 % interval; null: where the effect is absent; bounds: what is physical; in `unit`

    also: values at other minima that the data do not tell from this one; the interval holds theirs too
    """

    name: str
    unit: str
    value: float
    lower: float
    upper: float
    null: float
    lower_bound: float
    upper_bound: float
    also: tuple[float, ...] = ()


@dataclass(frozen=True)
class Candidate:
    """An effect of the catalogue as the data see it.

    sentence: what an engineer would say is missing; score: of the score test, in standard deviations
    visibility: share of its signature that the nuisance parameters cannot imitate, 0 to 1
    predicted_drop: of chi2, by the score test, with as much noise as the misfit asks for; obtained_drop: of the misfit
        (`residual.fit.misfit`), by the refit; delta_bic: BIC without less BIC with it
    held_out_gain: relative fall of the weighted residual RMS on force levels and mode that the fit never saw
    obtained_drop, delta_bic and held_out_gain are nan and `parameters` is empty where it was not refitted
    accepted: passed every test, and none explains the data better; reason: why not, "" where accepted
    """

    name: str
    sentence: str
    score: float
    visibility: float
    predicted_drop: float
    obtained_drop: float
    delta_bic: float
    held_out_gain: float
    parameters: tuple[FittedParameter, ...]
    accepted: bool
    reason: str


@dataclass(frozen=True)
class ErrorReached:
    """Weighted residual RMS on the data of the fit and on what was held out (nan where nothing was), before and after
    the effects; repeatability: what repeats alone give, nan where there are none"""

    before: float
    after: float
    held_out_before: float
    held_out_after: float
    repeatability: float


@dataclass(frozen=True, eq=False)
class Signature:
    """Change of the residual that an effect makes over one run at one channel, next to the residual to be explained.

    frequency: (n,) [Hz]; amplitude, phase: (n,) of the effect, orthogonal to the nuisance parameters and scaled to
    fit; residual_amplitude, residual_phase: (n,) after calibration; all four in standard deviations
    """

    effect: str
    run: str
    mode: str
    level: float
    channel: str
    frequency: Floats
    amplitude: Floats
    phase: Floats
    residual_amplitude: Floats
    residual_phase: Floats


@dataclass(frozen=True, eq=False)
class Confounding:
    """cosine: (n, n) between the orthogonalised signatures of the `effects`; groups: those above the threshold"""

    effects: tuple[str, ...]
    cosine: Floats
    threshold: float
    groups: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class MissingForce:
    """What the model lacks in one mode, as a function of amplitude: Re(r/q) and Im(r/(omega q)) of the missing force r.

    level: (n,) force [N] of the point; amplitude: (n,) of the modal coordinate's displacement at the channel [m]
    stiffness: (n,) [N/m]; damping: (n,) [N s/m]; deviations: (n,) standard deviation of each
    reading: what the shape says ("falls with 1/amplitude, as Coulomb friction does")
    """

    mode: str
    level: Floats
    amplitude: Floats
    stiffness: Floats
    stiffness_deviation: Floats
    damping: Floats
    damping_deviation: Floats
    reading: str


@dataclass(frozen=True)
class Step:
    """One step of the history. effects: in the model after it, none in the first; error: weighted residual RMS on the
    data of the fit and, held_out, on the rest (nan where nothing was held out)"""

    effects: tuple[str, ...]
    error: float
    held_out: float


@dataclass(frozen=True)
class NextMeasurement:
    """sentence: what to measure and why; effects: the explanations it separates; separation: expected distance between
    them [standard deviations]; hours: of testing it takes"""

    sentence: str
    effects: tuple[str, ...]
    separation: float
    hours: float


@dataclass(frozen=True)
class StripEntry:
    """The verdict from a stated repeatability (relative) on, up to the next entry's; effects: named, with the group"""

    repeatability: float
    verdict: Outcome
    effects: tuple[str, ...]


@dataclass(frozen=True)
class FittedEffect:
    """An effect with its values in a fit, perhaps beside others."""

    name: str
    parameters: tuple[FittedParameter, ...]


@dataclass(frozen=True)
class Explanation:
    """A model that was fitted. effects: in it, none in the one as it is

    probability: beside the others, all as likely beforehand (`diagnosis/decision/explanations.py`)
    misfit, held_out: weighted residual RMS that it leaves on the data of the fit and on the rest (nan where nothing was
        held out)
    fitted: each of the effects, with its values beside the others; empty in files of before 27 November 2026
    """

    effects: tuple[str, ...]
    probability: float
    misfit: float
    held_out: float
    fitted: tuple[FittedEffect, ...] = ()


@dataclass(frozen=True, eq=False)
class Verdict:
    """verdict: adequate: nothing is missing beyond repeatability; identified: `effects` are missing; inseparable: of
    `group` some are, the data cannot say which, and with them those of `effects` that are not in it; unknown: something
    outside the catalogue is; undecidable: the data do not suffice

    sentence: the verdict in plain words
    candidates: every effect that was looked at, best first
    next_measurement: worth making, most separation per hour first
    calibration: nuisance parameters fitted together with `effects`, for `updamp add --with-calibration`: factors on
        the rig file's values; empty where they are not handed on
    strip: how the verdict hangs on the stated repeatability, the smallest first; empty where repeats tell it
    explanations: models that were fitted, the likeliest first
    """

    verdict: Outcome
    sentence: str
    effects: tuple[str, ...]
    group: tuple[str, ...]
    candidates: tuple[Candidate, ...]
    error: ErrorReached
    next_measurement: tuple[NextMeasurement, ...]
    signatures: tuple[Signature, ...]
    confounding: Confounding
    missing_forces: tuple[MissingForce, ...]
    history: tuple[Step, ...]
    provenance: Mapping[str, str]
    calibration: tuple[Calibrated, ...] = ()
    strip: tuple[StripEntry, ...] = ()
    explanations: tuple[Explanation, ...] = ()

    @property
    def outright(self) -> tuple[str, ...]:
        """Effects that are missing whichever of the group is."""
        return tuple(name for name in self.effects if name not in self.group)


# `diagnosis.json`, every number kept to the last digit: the fields of `Verdict` by their names, and `schema`; nan as
# null.
VERDICT_JSON = JsonDocument(Verdict, "updamp diagnosis 4", "updamp diagnose")
