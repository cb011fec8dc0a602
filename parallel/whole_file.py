"""Files that appear whole or not at all, and a sentence where the disk does not take them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import h5py


class DiskError(RuntimeError):
    """A file that could not be written; the message names it, why, and what to do."""


def write_whole(path: Path, content: bytes | memoryview) -> None:
    """The file's folder is made where it is missing. raises: DiskError"""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as error:
        raise DiskError(
            f"{path}: cannot be written to the disk: {error.strerror}; make room or mend it, and run the same again: "
            f"what is done so far is kept"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def whole_hdf5(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file to be filled. It is made in memory: on a full disk HDF5 itself ends the process (h5py 3.16).

    raises: DiskError
    """
    memory = BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        yield file
    write_whole(path, memory.getbuffer())
