"""The one place that reads and writes stage products: frozen dataclasses in HDF5.

A file holds one product. Its root carries the schema version, the code version, the time of creation, the hash of
what went into the product, and what it cost; every dataset carries its unit. Fields may be arrays, numbers, flags,
text, tuples of numbers or text, mappings from names to any of these, further dataclasses, or None.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

import h5py
import numpy as np

from updamp.parallel.whole_file import DAMAGED_HDF5, is_undamaged, whole_hdf5
from updamp.workflow.store_units import UNITS

SCHEMA_VERSION = 1

Product = TypeVar("Product")


class StoreError(RuntimeError):
    """A file that cannot be used as it is; the message says what to do about it."""

    def __init__(self, path: Path, reason: str) -> None:
        self.path, self.reason = path, reason
        super().__init__(f"{path}: {reason}; delete the file and run again, then it is computed anew")


class UnitError(TypeError):
    """A field whose unit (or whose kind) the store does not know: to be mended in the program, not in the file."""


@dataclass(frozen=True)
class Stamp:
    """Where a product comes from and what it cost.

    key: hash of everything that went into it
    seconds: wall time of each part of the work, by name
    intervals: (start, end) of the work, one pair a session [s since 1970]
    peak_memory: resident memory of the processes that did it [bytes]
    """

    key: str
    seconds: Mapping[str, float] = field(default_factory=dict)
    intervals: tuple[tuple[float, float], ...] = ()
    peak_memory: float = 0.0


def write(path: Path, product: Any, stamp: Stamp) -> None:
    """Write a frozen dataclass. The file appears whole or not at all; its folder is made when missing.

    raises: UnitError where a number has no unit in store_units.py or a field is of a kind that cannot be stored;
        DiskError where the disk does not take it
    """
    with whole_hdf5(path) as file:
        file.attrs["schema"] = SCHEMA_VERSION
        file.attrs["code_version"] = f"updamp {version('updamp')}"
        file.attrs["created"] = datetime.now(UTC).isoformat(timespec="seconds")
        file.attrs["input_hash"] = stamp.key
        file.attrs["seconds"] = json.dumps(dict(stamp.seconds))
        file.attrs["intervals"] = json.dumps(stamp.intervals)
        file.attrs["peak_memory_bytes"] = stamp.peak_memory
        _put(file, "product", product, owner=type(product).__name__)


def read(path: Path, kind: type[Product], part: str = "") -> Product:
    """Read a product of the class `kind`.

    part: name of a field: read that alone, `kind` is its class then

    raises: StoreError where the file is missing, damaged, of another schema or holds something else
    """
    with _opened(path) as file:
        product: Product = _get(path, file["product" + (f"/{part}" if part else "")], kind)
        return product


def read_stamp(path: Path) -> Stamp:
    """raises: StoreError as in `read`"""
    with _opened(path) as file:
        attributes = file.attrs
        return Stamp(
            key=str(attributes["input_hash"]),
            seconds=json.loads(attributes["seconds"]),
            intervals=tuple((float(a), float(b)) for a, b in json.loads(attributes["intervals"])),
            peak_memory=float(attributes["peak_memory_bytes"]),
        )


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """The file, open for reading; whatever goes wrong while it is read comes out as a StoreError."""
    if not path.is_file():
        raise StoreError(path, "no such file")
    if not is_undamaged(path):
        raise StoreError(path, "damaged: its checksum is another")
    try:
        with h5py.File(path, "r") as file:
            schema = file.attrs.get("schema")
            if schema != SCHEMA_VERSION:
                raise StoreError(path, f"written with schema {schema}, this version reads {SCHEMA_VERSION}")
            yield file
    except DAMAGED_HDF5 as error:
        raise StoreError(path, f"damaged or not written by updamp ({error})") from error


# --- writing: each kind of value knows how it is laid down; "kind" in the attributes says how to take it up ---


def _put(group: h5py.Group, name: str, value: Any, owner: str, unit: str | None = None) -> None:
    """owner: class and field, for messages; unit: that of the field, None where it states none."""
    if "/" in name or name in ("", "."):
        raise UnitError(f"{owner}: the name '{name}' cannot be stored; use letters, digits, '.', '_' and '-'")
    if is_dataclass(value) and not isinstance(value, type):
        _put_record(group.create_group(name, track_order=True), value)
    elif isinstance(value, Mapping):
        table = group.create_group(name, track_order=True)
        table.attrs["kind"] = "mapping"
        for key, entry in value.items():
            _put(table, key, entry, owner, unit)
    elif isinstance(value, tuple) and value and all(is_dataclass(entry) for entry in value):
        table = group.create_group(name, track_order=True)
        table.attrs["kind"] = "records"
        for number, entry in enumerate(value):
            _put_record(table.create_group(f"{number:04d}", track_order=True), entry)
    elif value is None:
        group.create_group(name).attrs["kind"] = "none"
    elif isinstance(value, tuple) and not value:
        group.create_group(name).attrs["kind"] = "empty"
    else:
        _put_dataset(group, name, value, owner, unit)


def _put_record(group: h5py.Group, record: Any) -> None:
    name = type(record).__name__
    group.attrs["kind"], group.attrs["class"] = "record", name
    units = UNITS.get(name, {})
    for entry in fields(record):
        _put(group, entry.name, getattr(record, entry.name), f"{name}.{entry.name}", units.get(entry.name))


def _put_dataset(group: h5py.Group, name: str, value: Any, owner: str, unit: str | None) -> None:
    is_tuple = isinstance(value, tuple)
    if isinstance(value, str) or (is_tuple and all(isinstance(entry, str) for entry in value)):
        dataset = group.create_dataset(name, data=list(value) if is_tuple else value, dtype=h5py.string_dtype())
        dataset.attrs["kind"] = "texts" if is_tuple else "text"
        return
    data = np.asarray(value)
    if data.dtype.kind not in "biufc" or (is_tuple and data.ndim > 1):
        raise UnitError(f"{owner} is a {type(value).__name__}, which cannot be stored")
    if unit is None:
        raise UnitError(f"{owner} has no unit; state it in UNITS of store_units.py")
    # Checksums tell a damaged file from a sound one; HDF5 has them for chunked data only.
    checked = {"fletcher32": True} if data.ndim and data.size else {}
    dataset = group.create_dataset(name, data=data, **checked)
    dataset.attrs["kind"] = "numbers" if is_tuple else "array" if isinstance(value, np.ndarray) else "number"
    dataset.attrs["unit"] = unit


# --- reading ---


def _get(path: Path, item: h5py.Group | h5py.Dataset, hint: Any) -> Any:
    kind = item.attrs["kind"]
    if kind == "record":
        return _get_record(path, item, hint)
    if kind == "records":
        return tuple(_get_record(path, item[name], hint) for name in sorted(item))
    if kind == "mapping":
        return {name: _get(path, entry, hint) for name, entry in item.items()}
    return _READERS[kind](item)


def _get_record(path: Path, item: h5py.Group, hint: Any) -> Any:
    kind = _record_class(hint)
    stored = str(item.attrs["class"])
    if kind is None or kind.__name__ != stored:
        raise StoreError(path, f"holds a {stored} where a {getattr(kind, '__name__', hint)} is wanted")
    names = [entry.name for entry in fields(kind)]
    if set(names) != set(item):
        differing = ", ".join(sorted(set(names) ^ set(item)))
        raise StoreError(path, f"its {stored} has other fields than this version's ({differing})")
    hints = get_type_hints(kind)
    return kind(**{name: _get(path, item[name], hints[name]) for name in names})


def _record_class(hint: Any) -> Any:
    """The dataclass in a type hint: itself, or what it is a mapping, tuple or option of."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    return next((found for part in get_args(hint) if (found := _record_class(part)) is not None), None)


_READERS: Mapping[str, Any] = {
    "none": lambda _: None,
    "empty": lambda _: (),
    "text": lambda item: item.asstr()[()],
    "texts": lambda item: tuple(item.asstr()[()].tolist()),
    "numbers": lambda item: tuple(item[()].tolist()),
    "number": lambda item: item[()].item(),
    "array": lambda item: item[()],
}
