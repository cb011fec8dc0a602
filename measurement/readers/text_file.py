"""The text of a CSV file in the encodings that programs write: UTF-8, UTF-16 with its byte order mark, or
Windows-1252, of which the printable part of Latin-1 is a part."""

import codecs
import csv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import IO

from updamp.measurement.measurement import MeasurementError
from updamp.rig.toml_file import UTF_16

LONGEST_LINE = 10_000  # characters; a longer one is no line of numbers
UTF8, WIDE, WINDOWS = "utf-8-sig", "utf-16", "cp1252"  # as Python calls them
_AT_ONCE = 1 << 20  # bytes
_EMPTY_CELLS = " \t\r\n\v\f\x1a,;"
_ZIP = b"PK\x03\x04"
_BLANKS = b"\t\n\v\f\r\x1a"  # the last one ends a file of DOS
_PRINTED = _BLANKS + bytes(b for b in range(0x20, 0x100) if b not in (0x7F, 0x81, 0x8D, 0x8F, 0x90, 0x9D))
_NOTES = {
    WIDE: "the text is UTF-16 and read as such",
    WINDOWS: "the text is not UTF-8; it is read as Windows-1252 (Latin-1)",
}


@dataclass(frozen=True)
class Start:
    """Where the rows of a table begin. codec: encoding; lines: those above, empty ones and comments aside"""

    codec: str
    lines: int


def encoding_of(path: Path) -> str:
    """UTF8, WIDE or WINDOWS. raises: MeasurementError where the file is no text"""
    with path.open("rb") as file:
        begin = file.read(len(_ZIP))
        if begin[:2] in UTF_16:
            return WIDE
        if begin == _ZIP:
            raise _no_text(path, "it is a zip archive, as workbooks of Excel are: save the sheet as CSV there")
        file.seek(0)
        decoder, utf_8, printed = codecs.getincrementaldecoder("utf-8")(), True, True
        chunk = b" "
        while chunk and (utf_8 or printed):
            chunk = file.read(_AT_ONCE)
            if b"\0" in chunk:
                raise _no_text(path, "it has bytes of zero: binary, or UTF-16 without its byte order mark")
            printed = printed and not chunk.translate(None, _PRINTED)
            utf_8 = utf_8 and _decodes(decoder, chunk)
    if not (utf_8 or printed):
        raise _no_text(path, "its bytes are neither UTF-8 nor Windows-1252: it is binary")
    return UTF8 if utf_8 else WINDOWS


def _decodes(decoder: codecs.IncrementalDecoder, chunk: bytes) -> bool:
    try:
        decoder.decode(chunk, final=not chunk)
    except UnicodeDecodeError:
        return False
    return True


def _no_text(path: Path, why: str) -> MeasurementError:
    return MeasurementError(f"{path}: no text ({why}); save it as text in UTF-8, or name the reader that suits it")


def encoding_notes(path: Path, codec: str) -> tuple[str, ...]:
    """What is to be told of a text that is not UTF-8."""
    return (f"{path.name}: {_NOTES[codec]}",) if codec in _NOTES else ()


@contextmanager
def opened(path: Path, codec: str, delimiter: str) -> Iterator[IO[str]]:
    """raises: MeasurementError where what is read is damaged text, or no table"""
    try:
        with path.open(encoding=codec, newline="") as file:
            yield file
    except UnicodeError as error:
        raise MeasurementError(
            f"{path}: damaged text in {codec.upper()} ({error}); export it again, in UTF-8"
        ) from None
    except csv.Error as error:
        raise MeasurementError(f"{path}: not a table parted by '{delimiter}' ({error})") from None


def lines_of(path: Path, file: IO[str]) -> Iterator[str]:
    """Without empty lines, of empty cells too, and comments. raises: MeasurementError for a line that is too long for
    one"""
    while line := file.readline(LONGEST_LINE):
        if len(line) == LONGEST_LINE:
            raise MeasurementError(
                f"{path}: a line of more than {LONGEST_LINE} characters; this is no table of numbers"
            )
        if _says_something(line):
            yield line


def _says_something(line: str) -> bool:
    return bool(line.strip(_EMPTY_CELLS)) and not line.startswith("#")


def line_of(path: Path, start: Start, row: int) -> int:
    """Number in the file, from 1, of a row of the table: empty lines and comments are counted here."""
    with path.open(encoding=start.codec, newline="") as file:
        lines = (number for number, line in enumerate(file, 1) if _says_something(line))
        return next(islice(lines, start.lines + row, None), 0)


def has_line_end(path: Path, codec: str) -> bool:
    """Whether the file ends with a line end, or a quote, and was not cut off within its last value."""
    size = 2 if codec == WIDE else 1
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - size, 0))
        return any(byte in b'\r\n"' for byte in file.read())
