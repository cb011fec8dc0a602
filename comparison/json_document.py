"""Frozen dataclasses of numbers and arrays to JSON values and back, by their type annotations, and `JsonDocument`: one
kept as a file with the name of its schema.

Complex arrays become {"re", "im"}, nan becomes null, infinities the words "Infinity" and "-Infinity" (JSON has no
numbers for them). A `float | None` keeps null for None and refuses nan, which would look the same in the file.
"""

import dataclasses
import json
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from updamp.parallel.whole_file import write_whole

T = TypeVar("T")
INFINITE = {"Infinity": math.inf, "-Infinity": -math.inf}
NEEDED = "the file was made by another version or edited; write it anew"


def encode(value: Any) -> Any:
    """What `json.dumps(..., allow_nan=False)` takes; raises: TypeError for a type that has no rule here, ValueError
    for nan where None is meant"""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _encode_fields(value)
    if isinstance(value, np.ndarray):
        return _encode_array(value)
    if isinstance(value, np.generic):
        return encode(value.item())
    if isinstance(value, Mapping):
        return {str(key): encode(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [encode(entry) for entry in value]
    if isinstance(value, float):
        return _encode_float(value)
    if value is None or isinstance(value, str | bool | int):
        return value
    raise TypeError(f"no JSON form for {type(value).__name__}")


def decode(kind: type[T], value: Any, place: str = "") -> T:
    """An object of dataclass `kind` from what `encode` made of one.

    place: how messages call it
    raises: ValueError naming the field and what is wrong with it
    """
    return typing.cast(T, _decode_fields(kind, value, place or kind.__name__.lower()))


def _encode_fields(value: Any) -> dict[str, Any]:
    hints = typing.get_type_hints(type(value))
    encoded = {}
    for field in dataclasses.fields(value):
        entry = getattr(value, field.name)
        if type(None) in typing.get_args(hints[field.name]) and isinstance(entry, float) and math.isnan(entry):
            raise ValueError(f"{type(value).__name__}.{field.name} is nan; None is how it says that there is no value")
        encoded[field.name] = encode(entry)
    return encoded


def _encode_float(value: float) -> float | str | None:
    if math.isnan(value):
        return None
    return value if math.isfinite(value) else ("Infinity" if value > 0 else "-Infinity")


def _encode_array(value: NDArray[Any]) -> Any:
    if np.iscomplexobj(value):
        return {"re": _encode_array(value.real), "im": _encode_array(value.imag)}
    if value.size == 0 and value.ndim > 1:
        return {"shape": list(value.shape)}
    return encode(value.tolist())


def _decode_fields(kind: Any, value: Any, place: str) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError(f"{place}: a table of fields is needed, found {type(value).__name__}; {NEEDED}")
    hints = typing.get_type_hints(kind)
    names = {field.name for field in dataclasses.fields(kind)}
    if set(value) != names:
        wrong = [f"no '{name}'" for name in sorted(names - set(value))]
        wrong += [f"unknown '{name}'" for name in sorted(set(value) - names)]
        raise ValueError(f"{place}: {', '.join(wrong)}; {NEEDED}")
    return kind(**{name: _decode(hints[name], value[name], f"{place}.{name}") for name in names})


def _decode(kind: Any, value: Any, place: str) -> Any:
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if dataclasses.is_dataclass(kind):
        return _decode_fields(kind, value, place)
    if origin is np.ndarray:
        return _decode_array(typing.get_args(arguments[1])[0], value, place)
    if origin is tuple:
        return _decode_tuple(arguments, value, place)
    if origin in (types.UnionType, typing.Union):
        inner = next(argument for argument in arguments if argument is not type(None))
        return None if value is None else _decode(inner, value, place)
    if origin is typing.Literal:
        if value not in arguments:
            raise ValueError(f"{place}: {value!r} is none of {', '.join(arguments)}; {NEEDED}")
        return value
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise ValueError(f"{place}: a table is needed, found {type(value).__name__}; {NEEDED}")
        return {key: _decode(arguments[1], entry, f"{place}.{key}") for key, entry in value.items()}
    return _decode_plain(kind, value, place)


def _decode_plain(kind: type, value: Any, place: str) -> Any:
    if kind is float:
        return _decode_float(value, place)
    if type(value) is not kind:  # isinstance would take True for an int
        raise ValueError(f"{place}: {kind.__name__} needed, found {value!r}; {NEEDED}")
    return value


def _decode_float(value: Any, place: str) -> float:
    if value is None:
        return math.nan
    if isinstance(value, str) and value in INFINITE:
        return INFINITE[value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{place}: a number is needed, found {value!r}; {NEEDED}")
    return float(value)


def _decode_tuple(arguments: tuple[Any, ...], value: Any, place: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise ValueError(f"{place}: a list is needed, found {type(value).__name__}; {NEEDED}")
    endless = len(arguments) == 2 and arguments[1] is Ellipsis
    kinds = arguments[:1] * len(value) if endless else arguments
    if len(kinds) != len(value):
        raise ValueError(f"{place}: {len(kinds)} entries needed, found {len(value)}; {NEEDED}")
    return tuple(
        _decode(kind, entry, f"{place}[{i}]") for i, (kind, entry) in enumerate(zip(kinds, value, strict=True))
    )


def _decode_array(dtype: type[np.generic], value: Any, place: str) -> NDArray[Any]:
    if isinstance(value, Mapping) and set(value) == {"shape"}:
        return np.zeros(value["shape"], dtype)
    if issubclass(dtype, np.complexfloating):
        if not isinstance(value, Mapping) or set(value) != {"re", "im"}:
            raise ValueError(f"{place}: lists 're' and 'im' are needed, found {type(value).__name__}; {NEEDED}")
        parts = [_decode_array(np.float64, value[part], f"{place}.{part}") for part in ("re", "im")]
        if parts[0].shape != parts[1].shape:
            raise ValueError(f"{place}: 're' has shape {parts[0].shape}, 'im' {parts[1].shape}; {NEEDED}")
        whole = np.empty(parts[0].shape, dtype)
        whole.real, whole.imag = parts  # adding would lose an infinite or nan part
        return whole
    if not isinstance(value, list):
        raise ValueError(f"{place}: a list is needed, found {type(value).__name__}; {NEEDED}")
    plain = _decode_entries(value, place) if issubclass(dtype, np.floating) else value
    try:
        array = np.array(plain, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{place}: no array of {dtype.__name__}: {error}; {NEEDED}") from error
    if not issubclass(dtype, np.floating) and array.tolist() != value:
        raise ValueError(f"{place}: entries are not all {dtype.__name__}; {NEEDED}")
    return array


def _decode_entries(value: Any, place: str) -> Any:
    if isinstance(value, list):
        return [_decode_entries(entry, place) for entry in value]
    return _decode_float(value, place)


@dataclass(frozen=True)
class JsonDocument(Generic[T]):
    """A dataclass kept as a JSON file.

    kind: of the dataclass; schema: name and version in the file; command: that writes the file
    """

    kind: type[T]
    schema: str
    command: str

    def to_json(self, value: T) -> dict[str, Any]:
        return {"schema": self.schema, **encode(value)}

    def from_json(self, content: dict[str, Any]) -> T:
        """raises: ValueError naming what is missing, unknown or of the wrong kind"""
        found = content.get("schema") if isinstance(content, dict) else None
        if found != self.schema:
            raise ValueError(
                f"schema is {found!r}, this version reads {self.schema!r}: write the file anew with '{self.command}'"
            )
        return decode(self.kind, {name: value for name, value in content.items() if name != "schema"})

    def write(self, path: Path, value: T) -> None:
        write_whole(path, json.dumps(self.to_json(value), allow_nan=False, indent=1).encode())

    def read(self, path: Path) -> T:
        """raises: ValueError naming the file and what is wrong with it"""
        try:
            return self.from_json(json.loads(path.read_text(encoding="utf-8")))
        except ValueError as error:  # JSONDecodeError and UnicodeDecodeError are ValueErrors
            raise ValueError(
                f"{path}: damaged, or not written by {self.command} ({error}); make it again with it"
            ) from error
