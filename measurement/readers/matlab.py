"""MATLAB files: of versions 5 to 7.2 (`matlab5.py`), and of 7.3, which is HDF5, through h5py."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import h5py
import numpy as np
from pydantic import Field

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers import matlab5
from updamp.measurement.readers.registry import register, usable_file
from updamp.measurement.recorded import Complex, RecordedChannel, RecordedSweep, complex_of
from updamp.parallel.whole_file import DAMAGED_HDF5
from updamp.rig.fields import InputTable

LARGEST_NUMBERS = 1e8  # in one variable: 1.6 GB
_TO_HERTZ = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * np.pi)}


class MatlabOptions(InputTable):
    """frequency: variable of the frequencies; frequency_unit: theirs, "Hz", "kHz" or "rad/s"; harmonics: of the rows of
    a channel's array, (n_harmonics, n) in MATLAB.

    A field of a structure is written with a point, as in MATLAB: "test.frequency".
    """

    frequency: Annotated[str, Field(examples=["frequency"])] = "frequency"
    frequency_unit: Literal["Hz", "kHz", "rad/s"] | None = None
    harmonics: Annotated[tuple[Annotated[int, Field(strict=True, ge=0)], ...], Field(examples=[[1, 2]])] = (1,)


@register("matlab", endings=(".mat",), options=MatlabOptions)
def read_matlab(path: Path, labels: tuple[str, ...], options: MatlabOptions) -> tuple[RecordedSweep, ...]:
    """One sweep: a label is the variable (or field) of the channel's complex amplitudes."""
    usable_file(path, 2e9)
    wanted = (options.frequency, *labels)
    variables, top = (_version_73 if h5py.is_hdf5(path) else _up_to_72)(path, wanted)
    if options.frequency not in variables:
        raise MeasurementError(f"{path}: no variable '{options.frequency}'; {near(options.frequency, top)}")
    frequency = np.real(variables[options.frequency]).ravel() * _TO_HERTZ[options.frequency_unit or "Hz"]
    channels = {
        label: RecordedChannel(_amplitude(path, label, variables[label], options, len(frequency)), options.harmonics)
        for label in labels
        if label in variables
    }
    used = {name.split(".")[0] for name in wanted}
    note = (
        f"{path.name}: frequency_unit is not stated; '{options.frequency}' is read in Hz "
        f"(allowed are {', '.join(_TO_HERTZ)})"
    )
    notes = () if options.frequency_unit else (note,)
    return (RecordedSweep("", None, "", frequency, channels, tuple(n for n in top if n not in used), notes),)


def _amplitude(path: Path, label: str, value: Complex, options: MatlabOptions, n: int) -> Complex:
    shape = (len(options.harmonics), n)
    array = np.atleast_2d(np.squeeze(value)).reshape(shape) if value.size == n == value.size * shape[0] else value
    if array.shape != shape:
        raise MeasurementError(
            f"{path}: '{label}' is {' x '.join(map(str, value.shape))}, wanted is {shape[0]} x {n}: a row for each of "
            f"harmonics = {list(options.harmonics)}, a column for each frequency"
        )
    return np.asarray(array, dtype=complex)


def _up_to_72(path: Path, wanted: tuple[str, ...]) -> tuple[dict[str, Any], tuple[str, ...]]:
    try:
        elements = matlab5.variables(path)
        for name, element in elements.items():
            _check_size(path, name, matlab5.head(element).size)
        needed = {name.split(".")[0] for name in wanted} & set(elements)
        content = {name: matlab5.whole(elements[name]) for name in needed}
        found = {name: value for name in wanted if (value := _numeric(path, name, content, _field)) is not None}
    except matlab5.DamagedFileError as error:
        raise MeasurementError(f"{path}: damaged or no MATLAB file ({error}); save it again from MATLAB") from None
    return found, tuple(elements)


def _version_73(path: Path, wanted: tuple[str, ...]) -> tuple[dict[str, Any], tuple[str, ...]]:
    try:
        with h5py.File(path, "r") as file:
            found = {name: value for name in wanted if (value := _numeric(path, name, file, _member)) is not None}
            return found, tuple(name for name in file if not name.startswith("#"))
    except MeasurementError:
        raise
    except DAMAGED_HDF5 as error:
        raise MeasurementError(f"{path}: damaged MATLAB v7.3 file ({error}); save it again from MATLAB") from None


def _field(holder: Any, name: str) -> Any:
    return holder.get(name) if isinstance(holder, Mapping) else holder.field(name)


def _member(holder: Any, name: str) -> Any:
    return holder.get(name) if isinstance(holder, h5py.Group) else None


def _numeric(path: Path, name: str, holder: Any, step: Callable[[Any, str], Any]) -> Complex | None:
    """The numbers under a name with points, None where there are none of that name."""
    value = holder
    for part in name.split("."):
        value = step(value, part)
        if value is None:
            return None
    if isinstance(value, matlab5.MatlabArray):
        _check_size(path, name, value.size)
        value = value.numbers()
    if isinstance(value, h5py.Dataset):
        _check_size(path, name, value.size)
        value = value[()].T  # MATLAB stores columns first
        if value.dtype.names == ("real", "imag"):
            value = complex_of(value["real"], value["imag"])
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "biufc":
        raise MeasurementError(f"{path}: '{name}' holds no numbers; name an array, such as \"test.frequency\"")
    return np.asarray(value, dtype=complex)


def _check_size(path: Path, name: str, size: int) -> None:
    if size > LARGEST_NUMBERS:
        raise MeasurementError(f"{path}: '{name}' has {size} numbers, over {LARGEST_NUMBERS:g} at once")
