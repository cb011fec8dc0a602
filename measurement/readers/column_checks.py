"""Amplitudes and phases in columns of their own: values that cannot be meant."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.table import Table
from updamp.measurement.readers.text_file import line_of
from updamp.measurement.recorded import Floats

# Wrapped phases lie within one turn, the difference of two of them within two; only unwrapped ones go beyond, and
# unwrapping leaves no step above half a turn.
SPAN, STEP = 4 * np.pi, np.pi


def check_columns(path: Path, table: Table, phase: Mapping[str, str], force: str) -> None:
    """phase: label -> column of its phase. The force's column holds amplitudes too where responses have phases.

    raises: MeasurementError for a negative amplitude
    """
    for label in dict.fromkeys((*phase, *([force] if phase else []))):
        if label in table.numbers:
            _check_amplitudes(path, table, label)


def _check_amplitudes(path: Path, table: Table, label: str) -> None:
    refuse_negative(path, label, table.numbers[label], lambda i: f"line {line_of(path, table.start, i)}")


def refuse_negative(path: Path, label: str, values: Floats, place: Callable[[int], str]) -> None:
    """Of amplitudes that have phases. place: of one of them. raises: MeasurementError naming the first"""
    if (negative := values < 0).any():
        i = int(np.argmax(negative))
        raise MeasurementError(
            f"{path}: {place(i)}: {label} = {values[i]:g}: an amplitude with a phase is not "
            f"negative (so are {negative.sum()} of {len(values)} values); mend it or its phase, or make amplitudes of "
            f"values in dB (10^(dB/20) of their reference)"
        )


def check_radians(path: Path, table: Table, phase: Mapping[str, str], sweeps: Sequence[NDArray[np.intp]]) -> None:
    """sweeps: rows of each. raises: as `refuse_no_radians`"""
    for column in phase.values():
        for rows in sweeps:
            refuse_no_radians(path, column, table.numbers[column][rows])


def refuse_no_radians(path: Path, name: str, values: Floats) -> None:
    """Of one sweep. raises: MeasurementError for phases that are neither wrapped nor unwrapped radians"""
    values = values[np.isfinite(values)]
    steps = np.abs(np.diff(values))
    if len(steps) and np.ptp(values) > SPAN and steps.max() > STEP:
        raise MeasurementError(
            f"{path}: {name} goes from {values.min():g} to {values.max():g} with steps of up to "
            f"{steps.max():.3g}: wrapped phases in rad do not go so far, and unwrapped ones have no such "
            f'steps; state phase_unit = "deg"'
        )
