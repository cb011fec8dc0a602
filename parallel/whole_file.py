"""Files that appear whole or not at all, and a sentence where the disk does not take them."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path

import h5py

# What h5py raises where a file's content is damaged: a link that leads nowhere is None, a type may be any.
DAMAGED_HDF5 = (OSError, KeyError, RuntimeError, ValueError, AttributeError, TypeError)


class DiskError(RuntimeError):
    """A file that could not be written; the message names it, why, and what to do."""


@contextmanager
def written_to(path: Path) -> Iterator[None]:
    """For what is inside to write the file: the system names no file where the disk is full. raises: DiskError"""
    try:
        yield
    except OSError as error:
        raise DiskError(
            f"{path}: cannot be written to the disk: {error.strerror or error}; make room or mend it, and run the same "
            f"again: what is done so far is kept"
        ) from error


def write_whole(path: Path, content: bytes | memoryview) -> None:
    """The file's folder is made where it is missing. raises: DiskError"""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with written_to(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(content)
            os.replace(temporary, path)
    finally:
        with suppress(OSError):  # there is none where its folder could not be made
            temporary.unlink(missing_ok=True)


MARK = b"updamp SHA-256 "  # at the end of a file, with the digest of all before


@contextmanager
def whole_hdf5(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file to be filled, with its checksum behind it, which HDF5 does not mind. It is made in memory: on a full
    disk HDF5 itself ends the process (h5py 3.16).

    raises: DiskError
    """
    memory = BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        yield file
    content = memory.getvalue()
    write_whole(path, content + MARK + hashlib.sha256(content).digest())


def is_undamaged(path: Path) -> bool:
    """Whether a file that `whole_hdf5` wrote is as it was written: HDF5 itself may end the process that reads another.
    True for files without a checksum too. raises: OSError"""
    length = len(MARK) + hashlib.sha256().digest_size
    with path.open("rb") as file:
        if (size := file.seek(0, os.SEEK_END)) < length:
            return True
        file.seek(size - length)
        mark, stated = file.read(len(MARK)), file.read()
        if mark != MARK:
            return True
        file.seek(0)
        found, left = hashlib.sha256(), size - length
        while left and (part := file.read(min(left, 1 << 20))):
            found.update(part)
            left -= len(part)
    return found.digest() == stated
