"""Time signals to a sweep: a record for each step of frequency, its harmonics, and the error of getting them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from updamp.measurement.harmonic_fit import HarmonicFit, fit_harmonics
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.recorded import Floats, RecordedChannel
from updamp.measurement.swept_fit import fit_swept
from updamp.rig.fields import InputTable, Quantity


def _with_the_first(harmonics: tuple[int, ...]) -> tuple[int, ...]:
    if 1 not in harmonics or list(harmonics) != sorted(set(harmonics)):
        raise ValueError("must increase and contain 1, that of the excitation, such as [1, 2, 3]")
    return harmonics


class TimeOptions(InputTable):
    """harmonics: sought; settle: cut off at the start of each step [s]; frequency: of a file with one step [Hz]"""

    harmonics: Annotated[
        tuple[Annotated[int, Field(strict=True, ge=1)], ...], AfterValidator(_with_the_first), Field(examples=[[1, 2]])
    ] = (1,)
    settle: Annotated[float, Quantity("s", "0.5 s", at_least=0)] = 0.0
    frequency: Annotated[float, Quantity("Hz", "430 Hz", above=0)] | None = None


@dataclass(frozen=True, eq=False)
class TimeStep:
    """frequency: as commanded [Hz]; time: (n,) [s]; signals: label -> (n,)
    swept: (n,) likewise, of a window of a sweep without stops; None of a step"""

    frequency: float
    time: Floats
    signals: Mapping[str, Floats]
    swept: Floats | None = None


def sweep_of_steps(
    path: Path, steps: Sequence[TimeStep], labels: Sequence[str], options: TimeOptions
) -> tuple[Floats, dict[str, RecordedChannel], tuple[str, ...]]:
    """Frequencies (n_steps,) [Hz], channels, and what was done in a sentence. labels: the force first

    raises: MeasurementError where a record is not finite, too short, or cannot be fitted
    """
    fits = [_fit(path, step, labels, options) for step in steps]
    amplitude = np.array([fit.amplitude for fit in fits]).transpose(1, 2, 0)
    deviation = np.array([fit.deviation for fit in fits]).transpose(1, 2, 0)
    channels = {label: RecordedChannel(amplitude[i], options.harmonics, deviation[i]) for i, label in enumerate(labels)}
    frequency = np.array([fit.frequency for fit in fits])
    shift = float(np.max(np.abs(frequency - [step.frequency for step in steps])))
    cut = f"the first {options.settle:g} s of each step cut off" if steps[0].swept is None else _of_sweep(steps)
    note = (
        f"{path.name}: harmonics by least squares from time signals, {cut}; frequencies corrected by at most "
        f"{shift:.2g} Hz from the drift of the force's phase"
    )
    return frequency, channels, (note,)


def _of_sweep(steps: Sequence[TimeStep]) -> str:
    """How fast it was, and what cannot follow that (ISO 7626-2, as G. Gloth and M. Sinapius quote it, Mech. Syst.
    Signal Process. 18 (2004) 1421: at most 54 Hz a minute for a half-power bandwidth of 1 Hz, by the square of it)."""
    rate = max(abs(step.swept[-1] - step.swept[0]) / np.ptp(step.time) for step in steps if step.swept is not None)
    narrowest = float(np.sqrt(60 * rate / 54))
    return (
        f"swept without stops by at most {rate:.2g} Hz/s, in {len(steps)} windows; resonances with a half-power "
        f"bandwidth below {narrowest:.2g} Hz are distorted by such a sweep (ISO 7626-2)"
    )


def _fit(path: Path, step: TimeStep, labels: Sequence[str], options: TimeOptions) -> HarmonicFit:
    where = f"{path}: step of {step.frequency:g} Hz"
    lasts = float(np.ptp(step.time))
    if 0 < options.settle >= lasts:
        raise MeasurementError(
            f"{where}: settle = {options.settle:g} s is all of the step, which lasts {lasts:.4g} s; shorten settle, or "
            f"leave the step out"
        )
    settled = step.time >= step.time[0] + options.settle
    signals = np.array([step.signals[label][settled] for label in labels])
    for label, signal in zip(labels, signals, strict=True):
        if not np.isfinite(signal).all():
            raise MeasurementError(
                f"{where}: channel '{label}': {np.sum(~np.isfinite(signal))} samples are no finite numbers; leave the "
                f"step out or export it again"
            )
    try:
        if step.swept is not None:
            return fit_swept(step.time[settled], signals, step.swept[settled], options.harmonics)
        return fit_harmonics(step.time[settled], signals, step.frequency, options.harmonics)
    except ValueError as error:
        before = f" (settle = {options.settle:g} s of {lasts:.4g} s is cut off before)" if options.settle else ""
        raise MeasurementError(f"{where}: {error}{before}") from None
