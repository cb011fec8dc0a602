"""MATLAB's files of versions 5 to 7.2, read without trusting them: every number of bytes is held against what is there.

A file is a list of elements, each a kind, a number of bytes and its data; an array is an element of elements: flags,
dimensions and name, then its numbers, or the arrays of a structure's fields (The MathWorks, MAT-File Format). Read are
arrays of numbers and structures. scipy reads more, and ends the process where some files are damaged.
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Bytes of the header, whose last two are letters in the order of the bytes, and of an element's kind and length.
_HEADER, _TAG = 128, 8
_ORDERS = {b"IM": "<", b"MI": ">"}
_MATRIX, _COMPRESSED = 14, 15
# Elements of numbers.
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
# Arrays: structures, those of numbers, and objects of classes, which have no dimensions.
_STRUCTURE, _NUMERIC, _OPAQUE = 2, range(6, 16), 17
_IS_COMPLEX = 0x800
# NumPy's.
_MOST_DIMENSIONS = 64
# Bytes that have flags, dimensions and name of an array; and of one with all its fields.
_HEAD, _LARGEST = 1024, 2_000_000_000


class DamagedFileError(Exception):
    """What is wrong with it."""


@dataclass(frozen=True, eq=False)
class Element:
    """order: "<" or ">", of its bytes"""

    kind: int
    data: memoryview
    order: str


@dataclass(frozen=True, eq=False)
class MatlabArray:
    """kind: as MATLAB counts them; content: the elements after the name"""

    name: str
    kind: int
    is_complex: bool
    shape: tuple[int, ...]
    content: Element

    @property
    def size(self) -> int:
        return prod(self.shape)

    def numbers(self) -> NDArray[Any] | None:
        """None where it holds none. raises: DamagedFileError"""
        if self.kind not in _NUMERIC:
            return None
        real, *imaginary = (self._numbers_in(e) for e in _first(2 if self.is_complex else 1, self.content))
        if not imaginary:
            return real
        value = np.empty(real.shape, np.result_type(real, 1j))
        value.real, value.imag = real, imaginary[0]  # 1j * inf is not a number
        return value

    def field(self, name: str, number: int = 1) -> "MatlabArray | None":
        """Of a structure, or of one of an array of them, counted from 1. raises: DamagedFileError"""
        if self.kind != _STRUCTURE or not 1 <= number <= self.size:
            return None
        length, names = _first(2, self.content)
        width = int(_integers(length)[0])
        if width < 1 or len(names.data) % width:
            raise DamagedFileError(f"the names of the fields of '{self.name}' are not as long as stated")
        fields = [_text(names.data[i : i + width]) for i in range(0, len(names.data), width)]
        if name not in fields:
            return None
        before = (number - 1) * len(fields) + fields.index(name)
        return _array(_first(3 + before, self.content)[-1], name)

    def _numbers_in(self, element: Element) -> NDArray[Any]:
        if element.kind not in _NUMBERS:
            raise DamagedFileError(f"'{self.name}' has numbers of an unknown kind, {element.kind}")
        dtype = np.dtype(element.order + _NUMBERS[element.kind])
        if len(element.data) != self.size * dtype.itemsize:
            raise DamagedFileError(f"'{self.name}' has {len(element.data)} bytes for {self.size} numbers")
        return np.frombuffer(element.data, dtype).reshape(self.shape, order="F")


def variables(path: Path) -> dict[str, Element]:
    """By name, unread. raises: DamagedFileError, OSError"""
    content = memoryview(path.read_bytes())
    found = ((head(element).name, element) for element, _ in _elements(content[_HEADER:], _order(content)))
    return {name: element for name, element in found if name}


def head(element: Element) -> MatlabArray:
    """Its name, kind and shape; what it holds may be cut off. raises: DamagedFileError"""
    return _array(_inflated(element, _HEAD) if element.kind == _COMPRESSED else element)


def whole(element: Element) -> MatlabArray:
    """raises: DamagedFileError"""
    return _array(_inflated(element, _LARGEST) if element.kind == _COMPRESSED else element)


def _order(content: memoryview) -> str:
    order = _ORDERS.get(bytes(content[126:_HEADER]))
    if order is None:
        raise DamagedFileError("its header is not that of MATLAB 5 to 7.2")
    return order


def _inflated(element: Element, most: int) -> Element:
    """The array that was compressed, or its first bytes, where there are more."""
    try:
        content = memoryview(zlib.decompressobj().decompress(element.data, _TAG + most))
    except zlib.error as error:
        raise DamagedFileError(f"a compressed variable cannot be unpacked: {error}") from None
    if len(content) < _TAG:
        raise DamagedFileError("a compressed variable is empty")
    kind, stated = (int(n) for n in np.frombuffer(content[:_TAG], element.order + "u4"))
    if len(content) - _TAG < min(stated, most):
        raise DamagedFileError(f"a compressed variable has {len(content) - _TAG} bytes, {stated} are stated")
    return Element(kind, content[_TAG : _TAG + stated], element.order)


def _array(element: Element, name: str = "") -> MatlabArray:
    """name: of the field that it is, if it is one: then it has none of its own"""
    if element.kind != _MATRIX:
        raise DamagedFileError(f"an array is wanted, and there is an element of kind {element.kind}")
    if not len(element.data):  # a field that was never filled
        return MatlabArray(name, 0, False, (0, 0), element)
    parts = _elements(element.data, element.order)
    flags = int(_integers(_next(parts)[0])[0])
    kind = flags & 0xFF
    shape = () if kind == _OPAQUE else tuple(int(n) for n in _integers(_next(parts)[0]))
    if min(shape, default=0) < 0 or len(shape) > _MOST_DIMENSIONS:
        raise DamagedFileError(f"an array has the dimensions {shape[:_MOST_DIMENSIONS]}")
    of_name, end = _next(parts)
    content = Element(_MATRIX, element.data[end:], element.order)
    return MatlabArray(name or _text(of_name.data), kind, bool(flags & _IS_COMPLEX), shape, content)


def _elements(data: memoryview, order: str) -> Iterator[tuple[Element, int]]:
    """Each with where the next one begins."""
    at = 0
    while at < len(data):
        if at + _TAG > len(data):
            raise DamagedFileError("it ends within an element")
        first, stated = (int(n) for n in np.frombuffer(data[at : at + _TAG], order + "u4"))
        if small := first >> 16:  # up to four bytes are kept in the tag itself
            kind, start, length, end = first & 0xFFFF, at + 4, small, at + _TAG
        else:
            kind, start, length = first, at + _TAG, stated
            end = start + length if kind == _COMPRESSED else start + -(-length // 8) * 8
        if start + length > len(data) or (small and small > 4):
            raise DamagedFileError(f"an element of {length} bytes is stated, {len(data) - start} are left")
        yield Element(kind, data[start : start + length], order), end
        at = end


def _first(n: int, within: Element) -> list[Element]:
    parts = _elements(within.data, within.order)
    return [_next(parts)[0] for _ in range(n)]


def _next(parts: Iterator[tuple[Element, int]]) -> tuple[Element, int]:
    found = next(parts, None)
    if found is None:
        raise DamagedFileError("an array ends before what it has to have")
    return found


def _integers(element: Element) -> NDArray[Any]:
    """At least one"""
    dtype = np.dtype(element.order + _NUMBERS.get(element.kind, "f8"))
    if dtype.kind == "f" or not len(element.data) or len(element.data) % dtype.itemsize:
        raise DamagedFileError("an array has no dimensions, or its flags are not whole numbers")
    return np.frombuffer(element.data, dtype)


def _text(data: memoryview) -> str:
    return bytes(data).split(b"\0")[0].decode("latin-1")
