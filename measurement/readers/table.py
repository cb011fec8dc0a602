"""Tables of numbers as text, read in pieces: numbers and codes are kept, no text, so a gigabyte fits into memory."""

import csv
import json
import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO, Literal

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers.registry import usable_file
from updamp.rig.fields import InputTable
from updamp.rig.toml_file import UTF_16

LARGEST = 2e9  # bytes; the long form takes 1.7 GB of memory for a file of 1 GB
LINES_AT_ONCE = 100_000
OTHER_DELIMITERS = {";": "semicolon", ",": "comma", "\t": "tab"}
LONGEST_LINE = 10_000  # characters; a longer one is no line of numbers

Floats = NDArray[np.float64]
_COMMAS = str.maketrans({",": ".", ".": " . "})  # a point beside decimal commas parts thousands: no number here


class CsvForm(InputTable):
    """How a CSV file is written. delimiter: between its columns; decimal: "," where its numbers have decimal commas"""

    delimiter: Literal[",", ";", "\t"] = ","
    decimal: Literal[".", ","] = "."

    def plain(self, text: str) -> str:
        """The text of a number with a decimal point."""
        return text if self.decimal == "." else text.translate(_COMMAS)


PLAIN = CsvForm()


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
    """header: all columns; numbers: (n,) by column; texts: by column; notes: what was taken for granted"""

    header: tuple[str, ...]
    numbers: dict[str, Floats]
    texts: dict[str, Codes]
    notes: tuple[str, ...] = ()


def read_table(path: Path, numeric: Collection[str], text: Collection[str] = (), form: CsvForm = PLAIN) -> Table:
    """A header line and lines below it; those that start with # are comments. Columns not named are skipped.

    raises: MeasurementError where the file is missing, empty, too large, no text, has no such columns, is cut off or
        has something else than numbers in a numeric column
    """
    usable_file(path, LARGEST)
    with _opened(path, form.delimiter) as file:
        reader = csv.reader(_lines(path, file), skipinitialspace=True, delimiter=form.delimiter)
        header = _header(path, reader, form.delimiter)
        _check_columns(path, header, [*numeric, *text])
        return _body(path, reader, header, numeric, text, form)


def header_of(path: Path, form: CsvForm = PLAIN) -> tuple[str, ...]:
    """Names of the columns. raises: MeasurementError as in `read_table`"""
    usable_file(path)
    with _opened(path, form.delimiter) as file:
        reader = csv.reader(_lines(path, file), skipinitialspace=True, delimiter=form.delimiter)
        return _header(path, reader, form.delimiter)


@contextmanager
def _opened(path: Path, delimiter: str) -> Iterator[IO[str]]:
    """raises: MeasurementError where what is read is no text in UTF-8, or no table"""
    with path.open("rb") as start:
        if start.read(2) in UTF_16:
            raise MeasurementError(f"{path}: the text is UTF-16; save it as UTF-8")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            yield file
    except UnicodeDecodeError as error:
        raise MeasurementError(
            f"{path}: not a text file in UTF-8 ({error}); save it as UTF-8, or name the reader that suits it"
        ) from None
    except csv.Error as error:
        raise MeasurementError(f"{path}: not a table parted by '{delimiter}' ({error})") from None


def _header(path: Path, reader: Iterator[list[str]], delimiter: str) -> tuple[str, ...]:
    header = tuple(name.strip() for name in next(reader, []))
    for other, name in OTHER_DELIMITERS.items():
        if len(header) == 1 and other != delimiter and other in header[0]:
            raise MeasurementError(
                f"{path}: its columns are parted by {name}s, '{delimiter}' is wanted here; state in its run options = "
                f'{{ delimiter = {json.dumps(other)} }}, and decimal = "," beside it where numbers have decimal commas'
            )
    if twice := next((name for name in header if header.count(name) > 1), None):
        raise MeasurementError(
            f"{path}: header = {','.join(header)[:80]!r}: {header.count(twice)} columns have the name '{twice[:60]}'; "
            f"give each its own"
        )
    return header


def _lines(path: Path, file: IO[str]) -> Iterator[str]:
    while line := file.readline(LONGEST_LINE):
        if len(line) == LONGEST_LINE:
            raise MeasurementError(
                f"{path}: a line of more than {LONGEST_LINE} characters; this is no table of numbers"
            )
        if line.strip() and not line.startswith("#"):
            yield line


def _check_columns(path: Path, header: tuple[str, ...], wanted: Sequence[str]) -> None:
    for name in wanted:
        if name not in header:
            raise MeasurementError(f"{path}: no column '{name[:60]}'; {near(name, header)}")


def _body(
    path: Path,
    reader: Iterator[list[str]],
    header: tuple[str, ...],
    numeric: Collection[str],
    text: Collection[str],
    form: CsvForm,
) -> Table:
    place = {name: header.index(name) for name in (*numeric, *text)}
    codes = {name: Codes() for name in text}
    parts: dict[str, list[NDArray[np.int32]]] = {name: [] for name in text}
    values: dict[str, list[Floats]] = {name: [] for name in numeric}
    done, last = 0, ""
    while rows := list(islice(reader, LINES_AT_ONCE)):
        _check_rows(path, len(header), rows, done)
        columns = list(zip(*rows, strict=True))
        for name in numeric:
            values[name].append(_numbers(path, name, columns[place[name]], done, form))
        for name in text:
            parts[name].append(codes[name].of(columns[place[name]]))
        done, last = done + len(rows), rows[-1][-1]
    if done == 0:
        raise MeasurementError(f"{path}: a header and no line below it; export the data again")
    for name in text:
        codes[name].codes = np.concatenate(parts.pop(name))
    notes = _last_value(path, last) if header[-1] in place else ()
    return Table(header, {name: np.concatenate(values.pop(name)) for name in numeric}, codes, notes)


def _last_value(path: Path, text: str) -> tuple[str, ...]:
    """A file that was cut off within its last value shows it by nothing else than its missing line end."""
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        ended = file.read() in b'\r\n"'
    note = f"{path.name}: no line end after its last value, {text[:40]}: taken as complete, as if nothing were cut off"
    return () if ended else (note,)


def _check_rows(path: Path, width: int, rows: list[list[str]], before: int) -> None:
    """before: rows of the file before these"""
    for i, row in enumerate(rows):
        if len(row) != width:
            raise MeasurementError(
                f"{path}: line {line_of(path, before + i)}, {','.join(row)[:60]!r}, has {len(row)} columns, the "
                f"header {width}; the file is cut off or its columns are parted otherwise (decimal commas need "
                f"semicolons between columns)"
            )


def line_of(path: Path, row: int) -> int:
    """Number in the file, from 1, of a row below the header: empty lines and comments are counted here."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = (number for number, line in enumerate(file, 1) if line.strip() and not line.startswith("#"))
        return next(islice(lines, row + 1, None), 0)


def _numbers(path: Path, column: str, texts: Sequence[str], before: int, form: CsvForm) -> Floats:
    try:
        return np.array([form.plain(text) for text in texts], dtype=np.float64)
    except ValueError:
        i, bad = next((i, text) for i, text in enumerate(texts) if not _is_number(form.plain(text)))
        raise MeasurementError(
            f'{path}: line {line_of(path, before + i)}: {column} = "{bad[:60]}": not a number; {_remedy(bad, form)}'
        ) from None


def _remedy(bad: str, form: CsvForm) -> str:
    if form.decimal == ",":
        return 'with decimal = "," numbers have a decimal comma and no points'
    if _is_number(bad.translate(_COMMAS)):
        return 'write numbers with a decimal point, or state in its run options = { decimal = "," } with its delimiter'
    if bad.strip() and not any(sign.isdigit() for sign in bad):
        return "take its line out (units belong into measurement.toml), or begin it with # as a comment"
    return "write numbers with a decimal point"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
