"""Readers of data files: each registers itself by the one line above its function. Before it opens a file it asks
whether that can be used at all (`usable_file`)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.recorded import RecordedSweep
from updamp.rig.fields import InputTable


class ReadFunction(Protocol):
    """All sweeps of a file that have any of the wanted channels.

    labels: how the file calls the channels wanted, the force first
    options: of the reader's own class
    raises: MeasurementError naming the file, what is wrong with it and what to do
    """

    def __call__(self, path: Path, labels: tuple[str, ...], options: Any) -> tuple[RecordedSweep, ...]: ...


@dataclass(frozen=True)
class Reader:
    """endings: of the files it reads unless measurement.toml names another; options: its keys in `options = {...}`;
    of_samples: whether its files hold time signals, which it makes amplitudes from itself"""

    name: str
    endings: tuple[str, ...]
    options: type[InputTable]
    read: ReadFunction
    of_samples: bool = False


class NoOptions(InputTable):
    """A reader that has nothing to choose."""


_READERS: dict[str, Reader] = {}


def register(
    name: str, endings: tuple[str, ...] = (), options: type[InputTable] = NoOptions, of_samples: bool = False
) -> Callable[[ReadFunction], ReadFunction]:
    """Decorator of a reader's function. raises: ValueError where the name or an ending is taken"""

    def add(read: ReadFunction) -> ReadFunction:
        registered = {ending for reader in _READERS.values() for ending in reader.endings}
        if name in _READERS or registered & set(endings):
            raise ValueError(f"reader '{name}' for {endings}: the name or an ending is taken already")
        _READERS[name] = Reader(name, endings, options, read, of_samples)
        return read

    return add


def readers() -> Mapping[str, Reader]:
    """All that have been registered, by name."""
    return _READERS


def reader_of(path: Path, name: str | None) -> Reader:
    """The reader of that name or else of the file's ending. raises: MeasurementError where there is none"""
    if name is not None:
        if name not in _READERS:
            raise MeasurementError(f'{path}: reader = "{name}": unknown; {near(name, _READERS)}')
        return _READERS[name]
    for reader in _READERS.values():
        if path.suffix.lower() in reader.endings:
            return reader
    endings = ", ".join(sorted(ending for reader in _READERS.values() for ending in reader.endings))
    raise MeasurementError(
        f"{path}: no reader for files ending in '{path.suffix}' (known are {endings}); "
        f'name one, such as reader = "{next(iter(_READERS))}"; there are {", ".join(_READERS)}'
    )


def usable_file(path: Path, largest: float = float("inf")) -> None:
    """largest: size in bytes that the reader can hold in memory

    raises: MeasurementError where the file is missing, a folder, empty or too large
    """
    if not path.exists():
        beside = (file.name for file in path.parent.iterdir()) if path.parent.is_dir() else ()
        raise MeasurementError(f"{path}: no such file; beside measurement.toml {near(path.name, sorted(beside))}")
    if not path.is_file():
        kind = "a folder" if path.is_dir() else "a device or pipe, no file"
        raise MeasurementError(f"{path}: is {kind}; name the data file itself")
    size = path.stat().st_size
    if size == 0:
        raise MeasurementError(f"{path}: the file is empty (0 bytes); export it again")
    if size > largest:
        raise MeasurementError(
            f"{path}: {size / 1e6:.0f} MB, more than the {largest / 1e6:.0f} MB that are read into memory; "
            f"split the file by run, or export amplitudes at the harmonics instead of time signals"
        )
