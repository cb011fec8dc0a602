"""Universal file format: every data set 58 of a file, whole, through pyuff."""

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyuff

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.registry import usable_file

LARGEST = 2.5e8  # bytes: pyuff keeps every number as a Python object, 2.1 GB of memory at 240 MB
HEADER_LINES = 13  # of a text data set 58: delimiter, number of the data set, records 1 to 11
FORMAT_LINE = 8  # record 7, the only one of the header with exponents
_DELIMITER = re.compile(rb" {4}-1(?= *[\r\n]| *\Z)")
_LINES = re.compile(rb"(?:[^\n]*\n){%d}" % HEADER_LINES)
_BLANKS = re.compile(rb"[ \t]+(?=\r?\n|\Z)")
_EMPTY_LINES = re.compile(rb"\n(?:\r?\n)+")
_EXPONENTS = bytes.maketrans(b"Dd", b"Ee")  # Fortran's double precision

Record = Mapping[str, Any]


def uff_records(path: Path) -> tuple[Record, ...]:
    """Every data set 58 of the file, as pyuff names its fields; "file_units": factors of length and force that the data
    set 164 before it states (a value over the factor is in SI), None where there is none.

    raises: MeasurementError where the file is cut off, is something else, or has no data set 58
    """
    usable_file(path, LARGEST)
    with tempfile.TemporaryDirectory() as folder:
        readable, kinds, units = _readable(path, Path(folder, "plain.uff"))
        found = _sets(path, readable, [place for place, kind in enumerate(kinds) if kind == 58])
    records = tuple({**record, "file_units": unit} for record, unit in zip(found, units, strict=True))
    for number, record in enumerate(records, 1):
        _check_whole(path, number, record)
    return records


def _readable(path: Path, copy: Path) -> tuple[Path, list[int], list[tuple[float, float] | None]]:
    """The file, or a copy of it that pyuff can read; kinds of its data sets; what data set 164 says to each 58."""
    content = path.read_bytes()
    places = [match.start() for match in _DELIMITER.finditer(content)]
    if not places:
        raise MeasurementError(f"{path}: no data set in it (no line '    -1'); this is no universal file")
    if len(places) % 2:
        raise MeasurementError(f"{path}: cut off: its last data set has no end; copy or export the file again")
    blocks = [content[start:end] for start, end in zip(places[::2], places[1::2], strict=True)]
    kinds = [_kind(block) for block in blocks]
    if 58 not in kinds:
        raise MeasurementError(f"{path}: no data set 58 in it, only {', '.join(map(str, kinds))}; export functions")
    plain = b"".join(_plain(block, kind) + b"    -1\n" for block, kind in zip(blocks, kinds, strict=True))
    if plain != content:
        copy.write_bytes(plain)
    return (path if plain == content else copy), kinds, _file_units(blocks, kinds)


def _kind(block: bytes) -> int:
    lines = block[:200].splitlines()
    text = lines[1][:6].strip() if len(lines) > 1 else b""
    return int(text) if text.isdigit() else 0


def _plain(block: bytes, kind: int) -> bytes:
    """Legal text as pyuff reads it: no blanks behind delimiters and numbers, exponents with E. Binary data stay."""
    block = b"    -1" + block[6:].lstrip(b" ")
    header = _LINES.match(block)
    if kind != 58 or header is None or b"b" in block[:200].splitlines()[1].lower():
        return block
    lines = header[0].splitlines(keepends=True)
    lines[FORMAT_LINE] = lines[FORMAT_LINE].translate(_EXPONENTS)
    numbers = _BLANKS.sub(b"", block[header.end() :]).translate(_EXPONENTS)
    return b"".join(lines) + _EMPTY_LINES.sub(b"\n", numbers)


def _sets(path: Path, readable: Path, sets: Sequence[int]) -> Sequence[Record]:
    try:
        found = pyuff.UFF(str(readable)).read_sets(list(sets))
    except Exception as error:  # pyuff wraps whatever it stumbles over in a bare Exception
        raise MeasurementError(f"{path}: cannot be read as a universal file ({error}); export it again") from None
    return found if isinstance(found, list) else [found]


def _file_units(blocks: Sequence[bytes], kinds: Sequence[int]) -> list[tuple[float, float] | None]:
    units: list[tuple[float, float] | None] = []
    now: tuple[float, float] | None = None
    for block, kind in zip(blocks, kinds, strict=True):
        if kind == 164:
            now = _factors(block)
        elif kind == 58:
            units.append(now)
    return units


def _factors(block: bytes) -> tuple[float, float] | None:
    """Record 2 of data set 164: two numbers of 25 columns."""
    lines = block.splitlines()
    try:
        line = lines[3].translate(_EXPONENTS)
        return float(line[:25]), float(line[25:50])
    except (ValueError, IndexError):
        return None


def _check_whole(path: Path, number: int, record: Record) -> None:
    wanted, found = int(record["num_pts"]), min(len(record["x"]), len(record["data"]))
    if found != wanted or wanted == 0:
        raise MeasurementError(
            f"{path}: its data set 58 number {number} ('{record['id1']}') has {found} values where its header says "
            f"{wanted}; the file is cut off or damaged, copy or export it again"
        )
