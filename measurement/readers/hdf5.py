"""HDF5 in the project's own schema: sweeps with units, noise and checksums, as `store.py` lays down its products."""

from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.registry import NoOptions, register, usable_file
from updamp.measurement.recorded import RecordedChannel, RecordedSweep
from updamp.parallel.whole_file import DAMAGED_HDF5, is_undamaged, whole_hdf5

SCHEMA_VERSION = 1
KIND = "updamp recorded sweeps"
LARGEST_NUMBERS = 1e8  # in one data set: 1.6 GB


@register("hdf5", endings=(".h5", ".hdf5"))
def read_hdf5(path: Path, labels: tuple[str, ...], options: NoOptions) -> tuple[RecordedSweep, ...]:  # noqa: ARG001
    """A file that `write_hdf5` wrote."""
    usable_file(path)
    if not is_undamaged(path):
        raise MeasurementError(f"{path}: damaged (its checksum is another); copy or write it again")
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("kind") != KIND or file.attrs.get("schema") != SCHEMA_VERSION:
                raise MeasurementError(
                    f"{path}: kind = {file.attrs.get('kind')!r}, schema = {file.attrs.get('schema')!r}; wanted are "
                    f"'{KIND}' and {SCHEMA_VERSION}, as write_hdf5 writes them (MATLAB's v7.3 ends in .mat)"
                )
            return tuple(_sweep(path, file["sweeps"][name], labels) for name in sorted(file["sweeps"]))
    except DAMAGED_HDF5 as error:
        if isinstance(error, MeasurementError):
            raise
        raise MeasurementError(f"{path}: damaged or no HDF5 file ({error}); copy or write it again") from None


def write_hdf5(path: Path, sweeps: Sequence[RecordedSweep]) -> None:
    """All that a recorded sweep holds; the file appears whole or not at all. raises: DiskError"""
    with whole_hdf5(path) as file:
        file.attrs["kind"], file.attrs["schema"] = KIND, SCHEMA_VERSION
        file.attrs["code_version"] = f"updamp {version('updamp')}"
        file.attrs["created"] = datetime.now(UTC).isoformat(timespec="seconds")
        for number, sweep in enumerate(sweeps):
            _put(file.create_group(f"sweeps/{number:05d}", track_order=True), sweep)


def _put(group: h5py.Group, sweep: RecordedSweep) -> None:
    group.attrs["run"], group.attrs["sweep"] = sweep.run, sweep.sweep
    if sweep.repeat is not None:
        group.attrs["repeat"] = sweep.repeat
    group.create_dataset("frequency", data=sweep.frequency, fletcher32=True).attrs["unit"] = "Hz"
    table = group.create_group("channels", track_order=True)
    for number, (name, channel) in enumerate(sweep.channels.items()):
        entry = table.create_group(f"{number:04d}")  # a name may hold any character, a key may not
        for key in ("unit", "quantity", "direction", "per_force"):
            if (stated := getattr(channel, key)) is not None:
                entry.attrs[key] = stated
        entry.attrs["name"] = name
        entry.create_dataset("harmonics", data=np.array(channel.harmonics)).attrs["unit"] = "1"
        entry.create_dataset("amplitude", data=channel.amplitude, fletcher32=True).attrs["unit"] = channel.unit
        if channel.noise is not None:
            entry.create_dataset("noise", data=channel.noise, fletcher32=True).attrs["unit"] = channel.unit


def _sweep(path: Path, group: h5py.Group, labels: tuple[str, ...]) -> RecordedSweep:
    entries = {str(_stated(path, entry, "name")): entry for entry in group["channels"].values()}
    frequency = _numbers(path, group["frequency"])
    channels = {label: _channel(path, label, entries[label], len(frequency)) for label in labels if label in entries}
    repeat = group.attrs.get("repeat")
    others = tuple(name for name in entries if name not in labels)
    run, sweep = str(_stated(path, group, "run")), str(_stated(path, group, "sweep"))
    return RecordedSweep(run, None if repeat is None else int(repeat), sweep, frequency, channels, others)


def _channel(path: Path, label: str, entry: h5py.Group, n: int) -> RecordedChannel:
    harmonics = tuple(int(k) for k in entry["harmonics"][()])
    amplitude = _numbers(path, entry["amplitude"])
    noise = _numbers(path, entry["noise"]) if "noise" in entry else None
    for values in (amplitude, noise):
        if values is not None and values.shape != (len(harmonics), n):
            raise MeasurementError(
                f"{path}: channel '{label}' has the shape {values.shape}, wanted is {(len(harmonics), n)} for its "
                f"{len(harmonics)} harmonics and {n} frequencies"
            )
    stated = {key: str(_stated(path, entry, key)) for key in ("unit", "quantity", "direction")}
    per_force = entry.attrs.get("per_force")
    return RecordedChannel(amplitude, harmonics, noise, None if per_force is None else bool(per_force), **stated)


def _stated(path: Path, group: h5py.Group, key: str) -> Any:
    """An attribute. raises: MeasurementError where it is missing"""
    if key not in group.attrs:
        raise MeasurementError(f"{path}: {group.name} has no attribute '{key}'; add it, or use write_hdf5")
    return group.attrs[key]


def _numbers(path: Path, dataset: h5py.Dataset) -> np.ndarray:
    if dataset.size > LARGEST_NUMBERS:
        raise MeasurementError(f"{path}: {dataset.name} has {dataset.size} numbers, over {LARGEST_NUMBERS:g} at once")
    return np.asarray(dataset[()])
