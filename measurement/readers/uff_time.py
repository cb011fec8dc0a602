"""Universal file format: time signals (data sets 58 and 58b of function type 1) to harmonics.

The records of one step of frequency share the second identification line (run) and the z-axis value, which is the
commanded frequency (z-axis of the kind 18); or the file has one step, whose frequency is an option.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers.registry import register
from updamp.measurement.readers.time_steps import TimeOptions, TimeStep, sweep_of_steps
from updamp.measurement.readers.uff_file import Record, uff_records
from updamp.measurement.readers.uff_record import (
    FREQUENCY,
    HERTZ,
    QUANTITIES,
    SECONDS,
    TIME,
    called,
    called_apart,
    direction,
    in_unit,
    names_of,
    stated_unit,
)
from updamp.measurement.readers.uff_runs import Part, parts_of
from updamp.measurement.recorded import RecordedChannel, RecordedSweep


@register("uff_time", options=TimeOptions, of_samples=True)
def read_uff_time(path: Path, labels: tuple[str, ...], options: TimeOptions) -> tuple[RecordedSweep, ...]:
    """One sweep for each run and repeat (version number) in the file."""
    records = uff_records(path)
    signals = [r for r in records if r["abscissa_spec_data_type"] == TIME and not np.iscomplexobj(r["data"])]
    if not signals:
        raise MeasurementError(
            f"{path}: record '{called(records[0])}' is no time signal; read it with reader = \"uff\""
        )
    kept = {id(record) for record in signals}
    skipped = dict.fromkeys(n for r in records if id(r) not in kept for n in names_of(r) if n in labels)
    notes = tuple(f"{path.name}: records '{label}' that are no time signals are not used" for label in skipped)
    parts = [replace(part, notes=(*part.notes, *notes)) for part in parts_of(path, signals, labels)]
    return tuple(_sweep(path, part, labels, options) for part in parts)


def _sweep(path: Path, part: Part, labels: tuple[str, ...], options: TimeOptions) -> RecordedSweep:
    run, records = part.run, part.records
    present = [label for label in labels if any(label in names_of(record) for record in records)]
    if labels[0] not in present:
        known = dict.fromkeys(name for record in records for name in names_of(record))
        raise MeasurementError(f"{path}: run '{run}' has no record '{labels[0]}', the force; {near(labels[0], known)}")
    steps: dict[float, dict[str, Record]] = {}
    for record in records:
        for label in set(present) & set(names_of(record)):
            signals = steps.setdefault(_commanded(path, record, options), {})
            if label in signals:
                raise MeasurementError(f"{path}: more than one signal of '{label}' in a step of run '{run}'")
            signals[label] = record
    frequency, channels, notes = sweep_of_steps(
        path, [_step(path, f, signals, present) for f, signals in steps.items()], present, options
    )
    first = next(iter(steps.values()))
    channels = {label: _labelled(channel, first[label]) for label, channel in channels.items()}
    others = called_apart([record for record in records if not set(present) & set(names_of(record))])
    return RecordedSweep(run, part.repeat, "", frequency, channels, others, (*part.notes, *notes))


def _commanded(path: Path, record: Record, options: TimeOptions) -> float:
    if options.frequency is not None:
        return options.frequency
    if record["z_axis_spec_data_type"] != FREQUENCY or record["z_axis_value"] <= 0:
        raise MeasurementError(
            f"{path}: record '{called(record)}' does not state its frequency (z-axis of type {FREQUENCY}); "
            f'for a file with one step, options = {{ frequency = "430 Hz" }}'
        )
    return float(record["z_axis_value"]) * in_unit(path, record, "z_axis", HERTZ)


def _step(path: Path, frequency: float, signals: dict[str, Record], labels: Sequence[str]) -> TimeStep:
    if absent := [label for label in labels if label not in signals]:
        raise MeasurementError(f"{path}: the step of {frequency:g} Hz has no signal of {', '.join(absent)}")
    times = {label: signals[label]["x"] * in_unit(path, signals[label], "abscissa", SECONDS) for label in labels}
    time = np.asarray(times[labels[0]], dtype=float)
    for label, other in times.items():
        if len(other) != len(time) or not np.allclose(other, time, rtol=0, atol=1e-3 * abs(time[1] - time[0])):
            raise MeasurementError(
                f"{path}: the step of {frequency:g} Hz: '{label}' is not sampled as '{labels[0]}' is; resample them"
            )
    return TimeStep(frequency, time, {label: np.asarray(signals[label]["data"], dtype=float) for label in labels})


def _labelled(channel: RecordedChannel, record: Record) -> RecordedChannel:
    return RecordedChannel(
        amplitude=channel.amplitude,
        harmonics=channel.harmonics,
        noise=channel.noise,
        unit=stated_unit(record),
        quantity=QUANTITIES.get(int(record["ordinate_spec_data_type"]), ""),
        direction=direction(record),
    )
