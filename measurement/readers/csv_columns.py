"""CSV with columns of its own for each channel, one line a frequency: as a spreadsheet has it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.column_checks import check_columns, check_radians
from updamp.measurement.readers.csv_form import CsvForm
from updamp.measurement.readers.gather import group_rows, repeat_number, sweep_direction, text_of
from updamp.measurement.readers.header import Wanted, header_of
from updamp.measurement.readers.registry import register
from updamp.measurement.readers.separate_parts import SeparateParts
from updamp.measurement.readers.table import Codes, Table, read_table
from updamp.measurement.readers.units_row import ANGLE, HERTZ, check_axis
from updamp.measurement.recorded import Complex, RecordedChannel, RecordedSweep

Column = Annotated[str, Field(examples=["frequency_Hz"])]


class ColumnOptions(CsvForm, SeparateParts):
    """Which columns hold what, with phases and imaginary parts in columns of their own (`SeparateParts`).

    run, repeat, sweep: columns that tell sweeps of one file apart
    """

    frequency: Column = "frequency_Hz"
    run: Column | None = None
    repeat: Column | None = None
    sweep: Column | None = None


@register("csv_columns", options=ColumnOptions)
def read_csv_columns(path: Path, labels: tuple[str, ...], options: ColumnOptions) -> tuple[RecordedSweep, ...]:
    """A label is the column of the channel's amplitude, or of its real part where `imaginary` names another column."""
    options.check_labels(path, labels, "column")
    header = header_of(path, Wanted((options.frequency,), labels), options)
    present = [label for label in labels if label in header.names]
    parts = [part for label in present for part in options.parts_of(label)]
    marks = [name for name in (options.run, options.repeat, options.sweep) if name is not None]
    table = read_table(path, header, [*dict.fromkeys((options.frequency, *present, *parts))], marks, options)
    absent = Codes(np.zeros(len(table.numbers[options.frequency]), np.int32), {"": 0})
    run, repeat, sweep = (
        table.texts[name] if name is not None else absent for name in (options.run, options.repeat, options.sweep)
    )
    used = {options.frequency, *present, *parts, *marks}
    others = tuple(name for name in header.names if name and name not in used)
    groups = group_rows(run, repeat, sweep)
    _check_units(path, table, options)
    check_columns(path, table, options.phase, labels[0])
    if options.phase_unit == "rad":
        check_radians(path, table, options.phase, groups)
    notes = (*table.notes, *_granted(path, labels[0], options, present, others))
    found = []
    for rows in groups:
        name = text_of(run, rows)
        channels = {
            label: RecordedChannel(_amplitude(table, options, label, rows)[None], unit=table.unit(label))
            for label in present
        }
        number = repeat_number(path, name, text_of(repeat, rows))
        direction = sweep_direction(path, name, text_of(sweep, rows))
        frequency = table.numbers[options.frequency][rows]
        found.append(RecordedSweep(name, number, direction, frequency, channels, others, notes))
    return tuple(found)


def _check_units(path: Path, table: Table, options: ColumnOptions) -> None:
    """raises: MeasurementError where the row of units has another one for frequencies or phases than they are read in,
    or for an imaginary part than for its real part"""
    check_axis(path, table.units, options.frequency, "Hz", HERTZ)
    for column in options.phase.values():
        check_axis(path, table.units, column, options.phase_unit or "rad", ANGLE)
    for label, column in options.imaginary.items():
        real, imaginary = table.unit(label), table.unit(column)
        if real and imaginary and real != imaginary:
            raise MeasurementError(
                f'{path}: options.imaginary: "{label}" = "{column}": the row of units has {real} for the one and '
                f"{imaginary} for the other, a real and an imaginary part have the same; name the column of the "
                f"imaginary part (that of a phase belongs into options.phase)"
            )


def _granted(
    path: Path, force: str, options: ColumnOptions, present: list[str], others: Sequence[str]
) -> tuple[str, ...]:
    """Where the responses have phases and the force has none: what they are taken to refer to."""
    with_phase = {*options.phase, *options.imaginary}
    if force not in present or force in with_phase or not with_phase:
        return ()
    note = f"{path.name}: no phase is named for the force, '{force}'; the others are taken as against the force"
    if options.imaginary and others:
        note += (
            f". Is one of the columns not used, {', '.join(others)}, its imaginary part? Then name it, such as "
            f'options.imaginary = {{ "{force}" = "{others[0]}" }}'
        )
    return (note,)


def _amplitude(table: Table, options: ColumnOptions, label: str, rows: NDArray[np.intp]) -> Complex:
    value = table.numbers[label][rows].astype(complex)
    return options.together(label, value, lambda column: table.numbers[column][rows])
