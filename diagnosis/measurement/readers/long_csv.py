"""CSV in long form: one line an amplitude.

A gigabyte is read within bounded memory: numbers and codes are kept, no text.
"""

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.measurement.measurement_errors import MeasurementError
from updamp.diagnosis.measurement.readers.file_checks import usable_file
from updamp.diagnosis.measurement.readers.gather import Samples, sweeps_from_samples
from updamp.diagnosis.measurement.readers.registry import NoOptions, register
from updamp.diagnosis.measurement.recorded import RecordedSweep

COLUMNS = ("run", "repeat", "sweep", "frequency_Hz", "channel", "harmonic", "real", "imag")
OPTIONAL = ("repeat", "sweep", "harmonic")
LARGEST = 2e9  # bytes: some 50 million lines, 2 GB in memory
LINES_AT_ONCE = 100_000
LONGEST_LINE = 10_000  # characters; a longer one is no line of numbers

Floats = NDArray[np.float64]


@register("long_csv", endings=(".csv",))
def read_long_csv(path: Path, labels: tuple[str, ...], options: NoOptions) -> tuple[RecordedSweep, ...]:  # noqa: ARG001
    """Header `run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag`, in any order; repeat, sweep and harmonic may
    be missing (harmonic 1 then). Lines that start with # are comments."""
    usable_file(path, LARGEST)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            samples = _samples(path, file, labels)
    except UnicodeDecodeError as error:
        raise MeasurementError(f"{path}: not a text file ({error}); name the reader that suits it") from None
    return sweeps_from_samples(path, samples)


def write_long_csv(path: Path, sweeps: Iterable[RecordedSweep]) -> None:
    """Numbers with all their digits, one line for each channel, frequency and harmonic.

    raises: ValueError where a channel is divided by force or carries noise, for which this form has no column
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for sweep in sweeps:
            repeat = "" if sweep.repeat is None else sweep.repeat
            for name, channel in sweep.channels.items():
                if channel.per_force or channel.noise is not None:
                    raise ValueError(f"{path}: channel '{name}' has noise or is divided by force; write HDF5 instead")
                for harmonic, values in zip(channel.harmonics, channel.amplitude.tolist(), strict=True):
                    for frequency, value in zip(sweep.frequency.tolist(), values, strict=True):
                        row = (sweep.run, repeat, sweep.sweep, frequency, name, harmonic, value.real, value.imag)
                        writer.writerow(row)


def lines(path: Path, file: IO[str]) -> Iterator[str]:
    """Lines that are no comments. raises: MeasurementError at one that no measurement has (memory stays bounded)"""
    while line := file.readline(LONGEST_LINE):
        if len(line) == LONGEST_LINE:
            raise MeasurementError(
                f"{path}: a line of more than {LONGEST_LINE} characters; this is no table of numbers"
            )
        if line.strip() and not line.startswith("#"):
            yield line


def numbers(path: Path, column: str, texts: Sequence[str]) -> Floats:
    """Of one column, (n,). raises: MeasurementError naming the first text that is no number"""
    try:
        return np.array(texts, dtype=np.float64)
    except ValueError:
        bad = next(text for text in texts if not _is_number(text))
        raise MeasurementError(
            f'{path}: {column} = "{bad}": not a number; write numbers with a decimal point and part columns by commas'
        ) from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


@dataclass
class _Codes:
    """Texts of a column as small numbers."""

    number: dict[str, int] = field(default_factory=dict)

    def of(self, texts: Iterable[str]) -> NDArray[np.int32]:
        table = self.number
        return np.array([table.setdefault(text, len(table)) for text in texts], dtype=np.int32)


def _samples(path: Path, file: IO[str], labels: tuple[str, ...]) -> Samples:
    reader = csv.reader(lines(path, file), skipinitialspace=True)
    header = [name.strip() for name in next(reader, [])]
    _check_header(path, header)
    texts = {name: _Codes() for name in ("run", "repeat", "sweep", "channel")}
    codes: list[NDArray[np.int32]] = []
    values: list[Floats] = []
    while rows := list(islice(reader, LINES_AT_ONCE)):
        _check_rows(path, header, rows)
        columns = dict(zip(header, zip(*rows, strict=True), strict=True))
        for name, standard in (("repeat", ""), ("sweep", ""), ("harmonic", "1")):
            columns.setdefault(name, (standard,) * len(rows))
        codes.append(np.array([texts[name].of(columns[name]) for name in texts]))
        parts = [numbers(path, name, columns[name]) for name in ("frequency_Hz", "harmonic", "real", "imag")]
        values.append(np.array(parts))
    if not values:
        raise MeasurementError(f"{path}: a header and no line below it; export the data again")
    keys = tuple({code: text for text, code in table.number.items()} for table in texts.values())
    return Samples(*keys, np.concatenate(codes, axis=1), np.concatenate(values, axis=1), labels)


def _check_header(path: Path, header: list[str]) -> None:
    missing = [name for name in COLUMNS if name not in header and name not in OPTIONAL]
    unknown = [name for name in header if name not in COLUMNS]
    if missing or unknown or len(set(header)) < len(header):
        raise MeasurementError(
            f"{path}: header = {','.join(header)[:80]!r}: wanted is {','.join(COLUMNS)}; for one column a channel name "
            f'reader = "csv_columns", for time signals reader = "time_csv"'
        )


def _check_rows(path: Path, header: list[str], rows: list[list[str]]) -> None:
    for row in rows:
        if len(row) != len(header):
            raise MeasurementError(
                f"{path}: line {','.join(row)[:60]!r} has {len(row)} columns, the header {len(header)}; "
                f"the file is cut off or not parted by commas"
            )
