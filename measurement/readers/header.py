"""The line of a CSV file that names its columns, which programs write below lines of their own: date, title, sensors.

It is the first line that has the columns wanted, or else a comment above the table that has them. Where none has, the
line that comes closest is taken, so that the error names what stands there.
"""

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, takewhile
from pathlib import Path

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers.csv_form import OTHER_DELIMITERS, PLAIN, CsvForm, looks_like_number
from updamp.measurement.readers.registry import usable_file
from updamp.measurement.readers.text_file import Start, encoding_notes, encoding_of, line_of, lines_of, opened

LARGEST = 2e9  # bytes; the long form takes 1.7 GB of memory for a file of 1 GB
SEARCHED = 500  # lines of text; no program writes that many above its table


@dataclass(frozen=True)
class Wanted:
    """Columns that tell the line of names. every: all of these; any_of: and at least one of these, if there are any"""

    every: tuple[str, ...]
    any_of: tuple[str, ...] = ()

    def are_in(self, names: Sequence[str]) -> bool:
        return set(self.every) <= set(names) and (not self.any_of or bool(set(self.any_of) & set(names)))

    def number_in(self, names: Sequence[str]) -> int:
        return len({*self.every, *self.any_of} & set(names))


@dataclass(frozen=True)
class Header:
    """names: of all columns; start: of what is below; line: number in the file; notes: on encoding and lines above"""

    names: tuple[str, ...]
    start: Start
    line: int
    notes: tuple[str, ...] = ()


def header_of(path: Path, wanted: Wanted, form: CsvForm = PLAIN) -> Header:
    """raises: MeasurementError where the file is missing, empty, too large, no text, has lines that are too long, is
    parted otherwise, or two columns have one name
    """
    usable_file(path, LARGEST)
    codec = encoding_of(path)
    with opened(path, codec, form.delimiter) as file:
        lines = list(islice(lines_of(path, file), SEARCHED))
    place = _place(lines, form.delimiter, wanted)
    found = place is not None
    if place is None and (of_comment := _of_comment(path, codec, form.delimiter, wanted)):
        return of_comment
    if place is None:
        place = _nearest(lines, form.delimiter, wanted)
        _check_delimiter(path, lines, place, form.delimiter, wanted)
    names, used = _row(lines, place, form.delimiter)
    if found or place == 0:
        _check_names(path, names)
    number = line_of(path, Start(codec, 0), place)
    notes = (*encoding_notes(path, codec), *_left_out(path, lines[:place], number))
    return Header(names, Start(codec, place + used), number, notes)


def check_column(path: Path, header: Header, name: str, what: str = "") -> None:
    """what: the column holds, for the message. raises: MeasurementError where there is no such column"""
    if name not in header.names:
        where = f" (names of columns are looked for in line {header.line})" if header.line > 1 else ""
        raise MeasurementError(f"{path}: no column '{name[:60]}'{what}; {near(name, header.names)}{where}")


def _row(lines: Sequence[str], place: int, delimiter: str) -> tuple[tuple[str, ...], int]:
    """Cells of the row that begins with that line, and the number of its lines: a cell in quotes may have several."""
    reader = csv.reader(lines[place:], skipinitialspace=True, delimiter=delimiter)
    try:
        return tuple(cell.strip() for cell in next(reader, [])), max(reader.line_num, 1)
    except csv.Error:  # a quote in a line above the table that is never closed
        return (), 1


def _place(lines: Sequence[str], delimiter: str, wanted: Wanted) -> int | None:
    """Of the first line that has the columns wanted."""
    return next((i for i in range(len(lines)) if wanted.are_in(_row(lines, i, delimiter)[0])), None)


def _of_comment(path: Path, codec: str, delimiter: str, wanted: Wanted) -> Header | None:
    """The comment above the table that has the columns wanted, as numpy and others write their names."""
    with opened(path, codec, delimiter) as file:
        above = takewhile(lambda line: line.startswith("#") or not line.strip(), islice(file, SEARCHED))
        for number, line in enumerate(above, 1):
            names, _ = _row([line.lstrip("#").lstrip()], 0, delimiter)
            if wanted.are_in(names):
                _check_names(path, names)
                note = f"{path.name}: line {number}, a comment, has the names of the columns"
                return Header(names, Start(codec, 0), number, (*encoding_notes(path, codec), note))
    return None


def _nearest(lines: Sequence[str], delimiter: str, wanted: Wanted) -> int:
    """Of the first line that has most of the columns wanted, or else most cells of text."""

    def closeness(place: int) -> tuple[int, int]:
        names, _ = _row(lines, place, delimiter)
        return wanted.number_in(names), sum(1 for name in names if name and not looks_like_number(name))

    return max(range(len(lines)), key=closeness, default=0)


def _check_delimiter(path: Path, lines: Sequence[str], place: int, delimiter: str, wanted: Wanted) -> None:
    """Where no line has the columns wanted. raises: MeasurementError where another delimiter makes more of the lines"""
    names, _ = _row(lines, place, delimiter)
    for other, called in OTHER_DELIMITERS.items():
        if other == delimiter:
            continue
        parted, _ = _row(lines, _nearest(lines, other, wanted), other)
        alone = len(names) == 1 and other in names[0]
        if wanted.are_in(parted) or wanted.number_in(parted) > wanted.number_in(names) or alone:
            raise MeasurementError(
                f"{path}: its columns are parted by {called}s, {json.dumps(delimiter)} is wanted here; state in its "
                f"run options = {{ delimiter = {json.dumps(other)} }}, and "
                'decimal = "," beside it where numbers have decimal commas'
            )


def _check_names(path: Path, names: tuple[str, ...]) -> None:
    if twice := next((name for name in names if name and names.count(name) > 1), None):
        raise MeasurementError(
            f"{path}: header = {','.join(names)[:80]!r}: {names.count(twice)} columns have the name '{twice[:60]}'; "
            f"give each its own"
        )


def _left_out(path: Path, above: Sequence[str], number: int) -> tuple[str, ...]:
    if not above:
        return ()
    what = f"the line above it, {_quoted(above[0])}, is"
    if len(above) > 1:
        what = f"the {len(above)} lines above it, {_quoted(above[0])} to {_quoted(above[-1])}, are"
    return (f"{path.name}: line {number} has the names of the columns; {what} left out",)


def _quoted(line: str) -> str:
    """In double quotes: single ones mark a channel's label in such notes."""
    text = " ".join(line.replace('"', " ").split())
    return f'"{text}"' if len(text) <= 60 else f'"{text[:57]}..."'
