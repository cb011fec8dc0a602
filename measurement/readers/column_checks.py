"""Amplitudes and phases in columns of their own: values that cannot be meant."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.table import Table
from updamp.measurement.readers.text_file import line_of

# Wrapped phases lie within one turn, the difference of two of them within two; only unwrapped ones go beyond, and
# unwrapping leaves no step above half a turn.
SPAN, STEP = 4 * np.pi, np.pi


def check_columns(path: Path, table: Table, phase: Mapping[str, str], force: str) -> None:
    """phase: label -> column of its phase. The force's column holds amplitudes too where responses have phases.

    raises: MeasurementError for a phase that is its own amplitude, or a negative amplitude
    """
    for label, column in phase.items():
        if label == column:
            raise MeasurementError(
                f'{path}: options.phase: "{label}" = "{column}" is the column of the amplitude itself; name that of '
                f"its phase"
            )
    for label in dict.fromkeys((*phase, *([force] if phase else []))):
        if label in table.numbers:
            _check_amplitudes(path, table, label)


def _check_amplitudes(path: Path, table: Table, label: str) -> None:
    values = table.numbers[label]
    if (negative := values < 0).any():
        i = int(np.argmax(negative))
        raise MeasurementError(
            f"{path}: line {line_of(path, table.start, i)}: {label} = {values[i]:g}: an amplitude with a phase is not "
            f"negative (so are {negative.sum()} of {len(values)} values); mend it or its phase, or make amplitudes of "
            f"values in dB (10^(dB/20) of their reference)"
        )


def check_radians(path: Path, table: Table, phase: Mapping[str, str], sweeps: Sequence[NDArray[np.intp]]) -> None:
    """sweeps: rows of each. raises: MeasurementError for phases that are neither wrapped nor unwrapped radians"""
    for column in phase.values():
        for rows in sweeps:
            values = table.numbers[column][rows]
            values = values[np.isfinite(values)]
            steps = np.abs(np.diff(values))
            if len(steps) and np.ptp(values) > SPAN and steps.max() > STEP:
                raise MeasurementError(
                    f"{path}: {column} goes from {values.min():g} to {values.max():g} with steps of up to "
                    f"{steps.max():.3g}: wrapped phases in rad do not go so far, and unwrapped ones have no such "
                    f'steps; state phase_unit = "deg"'
                )
