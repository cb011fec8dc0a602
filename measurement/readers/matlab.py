"""MATLAB files: of versions 5 to 7.2 (`matlab5.py`), and of 7.3, which is HDF5, through h5py."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import h5py
import numpy as np
from pydantic import Field

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.readers import matlab5
from updamp.measurement.readers.column_checks import refuse_negative, refuse_no_radians
from updamp.measurement.readers.registry import register, usable_file
from updamp.measurement.readers.separate_parts import SeparateParts
from updamp.measurement.recorded import Complex, Floats, RecordedChannel, RecordedSweep, complex_of
from updamp.parallel.whole_file import DAMAGED_HDF5

LARGEST_NUMBERS = 1e8  # in one variable: 1.6 GB
_OF_ARRAY = re.compile(r"([^()]+)(?:\(([1-9]\d{0,8})\))?")
_TO_HERTZ = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * np.pi)}


class MatlabOptions(SeparateParts):
    """frequency: variable of the frequencies; frequency_unit: theirs, "Hz", "kHz" or "rad/s"; harmonics: of the rows of
    a channel's array, (n_harmonics, n) in MATLAB; n numbers are of the first, and one number is a force at
    every frequency. phase, imaginary: in variables of their own (`SeparateParts`).

    A field of a structure is written with a point, an element of an array of structures with its number, as in MATLAB:
    "test.frequency", "test(2).frequency".
    """

    frequency: Annotated[str, Field(examples=["frequency"])] = "frequency"
    frequency_unit: Literal["Hz", "kHz", "rad/s"] | None = None
    harmonics: Annotated[tuple[Annotated[int, Field(strict=True, ge=0)], ...], Field(examples=[[1, 2]])] = (1,)


@register("matlab", endings=(".mat",), options=MatlabOptions)
def read_matlab(path: Path, labels: tuple[str, ...], options: MatlabOptions) -> tuple[RecordedSweep, ...]:
    """One sweep: a label is the variable (or field) of the channel's complex amplitudes, of their sizes where `phase`
    names another, of their real parts where `imaginary` does."""
    usable_file(path, 2e9)
    options.check_labels(path, labels, "variable")
    parts = [part for label in labels for part in options.parts_of(label)]
    wanted = (options.frequency, *labels, *parts)
    variables, top = (_version_73 if h5py.is_hdf5(path) else _up_to_72)(path, wanted)
    for name in (options.frequency, *parts):
        if name not in variables:
            raise MeasurementError(f"{path}: no variable '{name}'; {near(name, top)}")
    frequency = np.real(variables[options.frequency]).ravel() * _TO_HERTZ[options.frequency_unit or "Hz"]
    content = _Content(path, variables, options, labels[0], len(frequency))
    channels = {label: content.channel(label) for label in labels if label in variables}
    content.check_force()
    used = {_top_of(name) for name in wanted}
    return (RecordedSweep("", None, "", frequency, channels, tuple(n for n in top if n not in used), content.notes),)


@dataclass(frozen=True, eq=False)
class _Content:
    """variables: by name, the options' names among them; force: its label; n: frequencies"""

    path: Path
    variables: Mapping[str, Complex]
    options: MatlabOptions
    force: str
    n: int

    @property
    def notes(self) -> tuple[str, ...]:
        options, name = self.options, self.path.name
        found = []
        if not options.frequency_unit:
            units = f"(allowed are {', '.join(_TO_HERTZ)})"
            found.append(f"{name}: frequency_unit is not stated; '{options.frequency}' is read in Hz {units}")
        if self.force in self.variables and self.variables[self.force].size == 1 < self.n:
            found.append(f"{name}: '{self.force}' is one number, and taken as the force at each of the frequencies")
        return tuple(found)

    def channel(self, label: str) -> RecordedChannel:
        values, harmonics = self._rows(label, self.options.harmonics)
        if label in self.options.phase:
            self._check_sizes(label, values)
        if label in self.options.phase and self.options.phase_unit == "rad":
            for row in self._part(self.options.phase[label], harmonics):
                refuse_no_radians(self.path, self.options.phase[label], row)
        whole = self.options.together(label, values, lambda name: self._part(name, harmonics))
        return RecordedChannel(np.asarray(whole, dtype=complex), harmonics)

    def check_force(self) -> None:
        """Its sizes stand alone where responses have phases. raises: MeasurementError for a negative one"""
        values = self.variables.get(self.force)
        if self.options.phase and values is not None and not np.iscomplex(values).any():
            self._check_sizes(self.force, np.atleast_2d(values))

    def _check_sizes(self, label: str, values: Complex) -> None:
        if np.iscomplex(values).any():
            raise MeasurementError(
                f"{self.path}: '{label}' is complex and has a phase in options.phase; keep one of them"
            )
        for row in np.real(values):
            refuse_negative(self.path, label, row, lambda i: f"{label}({i + 1})")

    def _part(self, name: str, harmonics: tuple[int, ...]) -> Floats:
        value = self.variables[name]
        if np.iscomplex(value).any():
            raise MeasurementError(
                f"{self.path}: '{name}' is complex; wanted are the numbers of a phase or an imaginary part"
            )
        rows, of = self._rows(name, harmonics)
        if of != harmonics:
            raise MeasurementError(f"{self.path}: '{name}' has one harmonic where its amplitudes have {len(harmonics)}")
        return np.real(rows)

    def _rows(self, name: str, harmonics: tuple[int, ...]) -> tuple[Complex, tuple[int, ...]]:
        """(n_harmonics, n) and of which harmonics. raises: MeasurementError naming the sizes"""
        value, n, m = self.variables[name], self.n, len(harmonics)
        if (name == self.force and value.size == 1) or (value.size == n and m > 1):
            return np.broadcast_to(value.ravel(), (1, n)), (1,)
        array = value.reshape(1, n) if value.size == n else value
        if array.shape != (m, n):
            several = f"; of several channels save each as a variable, such as {name}_1 = {name}(:, 1)"
            raise MeasurementError(
                f"{self.path}: '{name}' is {' x '.join(map(str, value.shape))}, wanted is {m} x {n}: a row for each of "
                f"harmonics = {list(harmonics)}, a column for each frequency{several if n in value.shape else ''}"
            )
        return array, harmonics


def _up_to_72(path: Path, wanted: tuple[str, ...]) -> tuple[dict[str, Any], tuple[str, ...]]:
    try:
        elements = matlab5.variables(path)
        for name, element in elements.items():
            _check_size(path, name, matlab5.head(element).size)
        needed = {_top_of(name) for name in wanted} & set(elements)
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


def _top_of(name: str) -> str:
    """The variable that a field is in."""
    return _steps(name)[0][0]


def _steps(name: str) -> list[tuple[str, int]]:
    """Of "test(2).laser": ("test", 2), ("laser", 1)"""
    parts = (_OF_ARRAY.fullmatch(part) for part in name.split("."))
    return [(found[1], int(found[2] or 1)) if found else (name, 1) for found in parts]


def _field(holder: Any, number: int, name: str) -> Any:
    return holder.get(name) if isinstance(holder, Mapping) else holder.field(name, number)


def _member(holder: Any, number: int, name: str) -> Any:
    """Of an array of structures each field is an array of references."""
    if not isinstance(holder, h5py.Group):
        return None
    value = holder.get(name)
    if isinstance(value, h5py.Dataset) and value.dtype == h5py.ref_dtype and number <= value.size:
        return holder.file[value[()].ravel()[number - 1]]
    return value if number == 1 else None


def _numeric(path: Path, name: str, holder: Any, step: Callable[[Any, int, str], Any]) -> Complex | None:
    """The numbers under a name with points, None where there are none of that name."""
    value, number = holder, 1
    for part, of_next in _steps(name):
        value = step(value, number, part)
        if value is None:
            return None
        number = of_next
    if number != 1:
        raise MeasurementError(f"{path}: '{name}': a number in brackets counts structures; name one of their fields")
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
