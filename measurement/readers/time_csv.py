"""CSV of time signals: a column a channel, and one with the commanded frequency where the file holds several steps."""

from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers.registry import register
from updamp.measurement.readers.table import CsvForm, header_of, read_table
from updamp.measurement.readers.time_steps import TimeOptions, TimeStep, sweep_of_steps
from updamp.measurement.recorded import RecordedSweep


class TimeCsvOptions(TimeOptions, CsvForm):
    """time: column of the time [s]; step: column of the commanded frequency [Hz], which marks the steps"""

    time: Annotated[str, Field(examples=["time_s"])] = "time_s"
    step: Annotated[str, Field(examples=["frequency_Hz"])] = "frequency_Hz"


@register("time_csv", options=TimeCsvOptions, of_samples=True)
def read_time_csv(path: Path, labels: tuple[str, ...], options: TimeCsvOptions) -> tuple[RecordedSweep, ...]:
    """One sweep: its steps are the stretches over which the commanded frequency is constant and time does not start
    again."""
    header = header_of(path, options)
    if labels[0] not in header:
        raise MeasurementError(f"{path}: no column '{labels[0]}': the force; {near(labels[0], header)}")
    present = [label for label in labels if label in header]
    stepped = options.frequency is None
    numeric = [options.time, *present, *([options.step] if stepped else [])]
    table = read_table(path, dict.fromkeys(numeric), (), options)
    numbers = table.numbers
    time = numbers[options.time]
    commanded = numbers[options.step] if stepped else np.full(len(time), options.frequency)
    if not (np.isfinite(time).all() and np.isfinite(commanded).all()):
        raise MeasurementError(f"{path}: a time or a commanded frequency is no finite number; export the file again")
    begins = np.diff(commanded) != 0
    if stepped:  # one frequency may be commanded twice in a row, as where a sweep turns round
        begins |= time[1:] <= time[0]
    edges = [0, *(np.flatnonzero(begins) + 1).tolist(), len(time)]
    steps = [
        TimeStep(float(commanded[a]), time[a:b], {label: numbers[label][a:b] for label in present})
        for a, b in pairwise(edges)
    ]
    frequency, channels, notes = sweep_of_steps(path, steps, present, options)
    others = tuple(name for name in header if name not in numeric)
    return (RecordedSweep("", None, "", frequency, channels, others, (*table.notes, *notes)),)
