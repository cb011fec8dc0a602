"""Tables of numbers as text, read in pieces: numbers and codes are kept, no text, so a gigabyte fits into memory."""

import csv
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.csv_form import PLAIN, CsvForm, is_number, with_point
from updamp.measurement.readers.header import Header, check_column
from updamp.measurement.readers.text_file import Start, has_line_end, line_of, lines_of, opened
from updamp.measurement.readers.units_row import is_row_of_units, plain_unit, units_of_names

LINES_AT_ONCE = 100_000

Floats = NDArray[np.float64]


@dataclass
class Codes:
    """Texts of a column as small numbers. codes: (n,); label: what they stand for"""

    codes: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    number: dict[str, int] = field(default_factory=dict)

    def of(self, texts: Iterable[str]) -> NDArray[np.int32]:
        table = self.number
        return np.array([table.setdefault(text, len(table)) for text in texts], dtype=np.int32)

    @property
    def label(self) -> tuple[str, ...]:
        return tuple(self.number)


@dataclass(frozen=True, eq=False)
class Table:
    """header: all columns; numbers: (n,) by column; texts: by column; start: of its rows; notes: what was taken for
    granted; units: by column, without brackets, of the row of units, or of names such as "tip [mm]"
    """

    header: tuple[str, ...]
    numbers: dict[str, Floats]
    texts: dict[str, Codes]
    start: Start
    notes: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)

    def unit(self, column: str) -> str:
        """As the row of units, or its name, has it; "" where neither says anything."""
        return self.units.get(column, "")


def read_table(
    path: Path, header: Header, numeric: Collection[str], text: Collection[str] = (), form: CsvForm = PLAIN
) -> Table:
    """The lines below the header, without a row of units; those that start with # are comments. Columns not named are
    skipped.

    raises: MeasurementError where there are no such columns or no lines, or the file is cut off or has something else
        than numbers in a numeric column
    """
    for name in (*numeric, *text):
        check_column(path, header, name)
    with opened(path, header.start.codec, form.delimiter) as file:
        lines = islice(lines_of(path, file), header.start.lines, None)
        reader = csv.reader(lines, skipinitialspace=True, delimiter=form.delimiter)
        units, first = _units(header.names, numeric, next(reader, None))
        start = Start(header.start.codec, header.start.lines + (reader.line_num if units else 0))
        rows = _Rows(path, header.names, start, form)
        numbers, texts, last = _columns(rows, chain(first, reader), numeric, text)
    notes = header.notes
    if units:
        notes += (_note_on_units(path, line_of(path, header.start, 0), units),)
    if header.names[-1] in (*numeric, *text) and not has_line_end(path, start.codec):
        # A file that was cut off within its last value shows it by nothing else than its missing line end.
        told = f"no line end after its last value, {last[:40]}: taken as complete, as if nothing were cut off"
        notes += (f"{path.name}: {told}",)
    return Table(header.names, numbers, texts, start, notes, units or units_of_names(numeric))


def _units(
    names: tuple[str, ...], numeric: Collection[str], row: list[str] | None
) -> tuple[dict[str, str], list[list[str]]]:
    """Units by column where the row has them, and the rows that are to be read: itself where it has none."""
    if row is None:
        return {}, []
    by_column = dict(zip(names, row, strict=False))  # a row of units may be shorter than the table
    if not is_row_of_units([by_column.get(name, "") for name in numeric]):
        return {}, [row]
    return {name: plain_unit(by_column.get(name, "")) for name in numeric}, []


def _note_on_units(path: Path, number: int, units: Mapping[str, str]) -> str:
    told = ", ".join(f"'{name}' {unit}" for name, unit in units.items() if unit)
    return f"{path.name}: line {number} is taken as the row of units and left out: {told[:400]}"


@dataclass(frozen=True)
class _Rows:
    """What errors in the rows of a table have to name."""

    path: Path
    header: tuple[str, ...]
    start: Start
    form: CsvForm


def _columns(
    rows: _Rows, reader: Iterator[list[str]], numeric: Collection[str], text: Collection[str]
) -> tuple[dict[str, Floats], dict[str, Codes], str]:
    """Numbers and texts by column, and the text of the very last cell."""
    place = {name: rows.header.index(name) for name in (*numeric, *text)}
    codes = {name: Codes() for name in text}
    parts: dict[str, list[NDArray[np.int32]]] = {name: [] for name in text}
    values: dict[str, list[Floats]] = {name: [] for name in numeric}
    done, last = 0, ""
    while piece := list(islice(reader, LINES_AT_ONCE)):
        _check_rows(rows, piece, done)
        columns = list(zip(*piece, strict=True))
        for name in numeric:
            values[name].append(_numbers(rows, name, columns[place[name]], done))
        for name in text:
            parts[name].append(codes[name].of(columns[place[name]]))
        done, last = done + len(piece), piece[-1][-1]
    if done == 0:
        raise MeasurementError(f"{rows.path}: a header and no line below it; export the data again")
    for name in text:
        codes[name].codes = np.concatenate(parts.pop(name))
    return {name: np.concatenate(values.pop(name)) for name in numeric}, codes, last


def _check_rows(rows: _Rows, piece: list[list[str]], before: int) -> None:
    """before: rows of the file before these"""
    width = len(rows.header)
    for i, row in enumerate(piece):
        if len(row) != width:
            number = line_of(rows.path, rows.start, before + i)
            raise MeasurementError(
                f"{rows.path}: line {number}, {','.join(row)[:60]!r}, has {len(row)} columns, the "
                f"header {width}; the file is cut off or its columns are parted otherwise (decimal commas need "
                f"semicolons between columns)"
            )


def _numbers(rows: _Rows, column: str, texts: Sequence[str], before: int) -> Floats:
    plain = rows.form.plain
    try:
        if any("_" in text for text in texts):
            raise ValueError  # Python takes "1_000" for a number
        return np.array([plain(text) for text in texts], dtype=np.float64)
    except ValueError:
        i, bad = next((i, text) for i, text in enumerate(texts) if not is_number(plain(text)))
        number = line_of(rows.path, rows.start, before + i)
        raise MeasurementError(
            f'{rows.path}: line {number}: {column} = "{bad[:60]}": not a number; {_remedy(bad, rows.form)}'
        ) from None


def _remedy(bad: str, form: CsvForm) -> str:
    if not bad.strip():
        return "the cell is empty: fill it, or take its line out"
    if form.decimal == ",":
        return 'with decimal = "," numbers have a decimal comma and no points'
    if is_number(with_point(bad)):
        return 'write numbers with a decimal point, or state in its run options = { decimal = "," } with its delimiter'
    if bad.strip() and not any(sign.isdigit() for sign in bad):
        return "take its line out (units belong into measurement.toml), or begin it with # as a comment"
    return "write numbers with a decimal point"
