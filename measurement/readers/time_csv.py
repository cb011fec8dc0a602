"""CSV of time signals: a column a channel, and one with the commanded frequency where the file holds several steps."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from updamp.measurement.harmonic_fit import PERIODS
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.csv_form import CsvForm
from updamp.measurement.readers.header import Header, Wanted, check_column, header_of
from updamp.measurement.readers.registry import register
from updamp.measurement.readers.table import Floats, Table, read_table
from updamp.measurement.readers.time_steps import TimeOptions, TimeStep, sweep_of_steps
from updamp.measurement.readers.units_row import HERTZ, SECONDS, check_axis
from updamp.measurement.recorded import RecordedSweep
from updamp.measurement.swept_fit import phase_of_sweep


class TimeCsvOptions(TimeOptions, CsvForm):
    """time: column of the time [s]; step: column of the commanded frequency [Hz], which marks the steps
    periods: in each window of a sweep without stops
    """

    time: Annotated[str, Field(examples=["time_s"])] = "time_s"
    step: Annotated[str, Field(examples=["frequency_Hz"])] = "frequency_Hz"
    periods: Annotated[int, Field(strict=True, ge=PERIODS + 1, examples=[20])] = 20

    @model_validator(mode="before")
    @classmethod
    def _frequency_is_no_column(cls, options: Any) -> Any:
        """Elsewhere `frequency` names a column."""
        stated = options.get("frequency") if isinstance(options, dict) else None
        if isinstance(stated, str) and not any(sign.isdigit() for sign in stated):
            raise ValueError(
                f'frequency = "{stated}": is a value, such as "430 Hz", of a file with one step; the column of the '
                f'commanded frequency is named by step = "{stated}"'
            )
        return options


@register("time_csv", options=TimeCsvOptions, of_samples=True)
def read_time_csv(path: Path, labels: tuple[str, ...], options: TimeCsvOptions) -> tuple[RecordedSweep, ...]:
    """One sweep: its steps are the stretches over which the commanded frequency is constant and time does not start
    again; windows of as many periods each where it does not stop."""
    header = header_of(path, Wanted((options.time, labels[0])), options)
    check_column(path, header, labels[0], ": the force")
    present = [label for label in labels if label in header.names]
    numeric = [options.time, *present, *_column_of_steps(path, header, options)]
    table = read_table(path, header, dict.fromkeys(numeric), (), options)
    check_axis(path, table.units, options.time, "s", SECONDS)
    check_axis(path, table.units, options.step, "Hz", HERTZ)
    frequency, found, notes = sweep_of_steps(path, _steps(path, table, present, options), present, options)
    channels = {label: replace(channel, unit=table.unit(label)) for label, channel in found.items()}
    others = tuple(name for name in header.names if name and name not in numeric)
    return (RecordedSweep("", None, "", frequency, channels, others, (*table.notes, *notes)),)


def _column_of_steps(path: Path, header: Header, options: TimeCsvOptions) -> list[str]:
    """None where the file has one step. raises: MeasurementError where it is missing"""
    if options.frequency is not None:
        return []
    what = (
        ", that of the commanded frequency [Hz] (`step` names this column; `frequency` is a value, such as "
        'options = { frequency = "430 Hz" }, for a file with one step)'
    )
    check_column(path, header, options.step, what)
    return [options.step]


def _steps(path: Path, table: Table, present: Sequence[str], options: TimeCsvOptions) -> list[TimeStep]:
    """raises: MeasurementError where a time or a commanded frequency is not finite"""
    numbers, stepped = table.numbers, options.frequency is None
    time = numbers[options.time]
    commanded: Floats = numbers[options.step] if stepped else np.full(len(time), options.frequency)
    if not (np.isfinite(time).all() and np.isfinite(commanded).all()):
        raise MeasurementError(f"{path}: a time or a commanded frequency is no finite number; export the file again")
    begins = np.diff(commanded) != 0
    if stepped:  # one frequency may be commanded twice in a row, as where a sweep turns round
        begins |= time[1:] <= time[0]
    signals = {label: numbers[label] for label in present}
    if stepped and 2 * np.count_nonzero(begins) > len(time):
        return _windows(path, time, commanded, signals, options)
    edges = [0, *(np.flatnonzero(begins) + 1).tolist(), len(time)]
    return [
        TimeStep(float(commanded[a]), time[a:b], {label: values[a:b] for label, values in signals.items()})
        for a, b in pairwise(edges)
    ]


def _windows(
    path: Path, time: Floats, commanded: Floats, signals: Mapping[str, Floats], options: TimeCsvOptions
) -> list[TimeStep]:
    """Of a sweep without stops, where most samples have another commanded frequency than the one before: as many
    periods each, what is left over at the end aside.

    raises: MeasurementError where the sweep is shorter than a window or no sweep one way, its time does not rise or
        settle is stated
    """
    if options.settle:
        raise MeasurementError(
            f"{path}: settle = {options.settle:g} s: the commanded frequency changes from sample to sample, so nothing "
            f"settles; leave it out"
        )
    if not np.all(np.diff(time) > 0):
        raise MeasurementError(
            f"{path}: time starts again within a sweep without stops; split the file, a run is one sweep one way"
        )
    turns = phase_of_sweep(time, commanded) / (2 * np.pi)
    edges = np.searchsorted(turns, np.arange(0.0, turns[-1], options.periods))
    if len(edges) < 2:
        raise MeasurementError(
            f"{path}: {turns[-1]:.3g} periods are less than one window of periods = {options.periods}; state fewer"
        )
    middle = commanded[(edges[:-1] + edges[1:]) // 2]
    if abs(np.sum(np.sign(np.diff(middle)))) < len(middle) - 1:
        raise MeasurementError(
            f"{path}: column '{options.step}' changes from sample to sample and neither rises nor falls throughout: it "
            f"has to be constant over each step of a stepped sine (the frequency as commanded, not as measured), or be "
            f"one sweep one way"
        )
    return [
        TimeStep(float(f), time[a:b], {label: values[a:b] for label, values in signals.items()}, commanded[a:b])
        for f, (a, b) in zip(middle, pairwise(edges.tolist()), strict=True)
    ]
