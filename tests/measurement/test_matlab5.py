"""MATLAB's files of versions 5 to 7.2, whole and damaged."""

import contextlib
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers import matlab5
from updamp.measurement.readers.matlab import MatlabOptions, read_matlab

KINDS = [np.dtype(k) for k in ("f8", "f4", "c16", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "bool")]
SHAPES = hnp.array_shapes(min_dims=2, max_dims=3, min_side=0, max_side=4)
ARRAYS = st.sampled_from(KINDS).flatmap(lambda kind: hnp.arrays(kind, SHAPES))
NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,30}", fullmatch=True)
SAME_FOLDER = settings(
    deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@SAME_FOLDER
@given(
    arrays=st.dictionaries(NAMES, ARRAYS, min_size=1, max_size=4),
    fields=st.dictionaries(NAMES, ARRAYS, min_size=1, max_size=4),
    compressed=st.booleans(),
)
@example(arrays={"a": np.array([[complex(0, np.inf)]])}, fields={"b": np.zeros((0, 0))}, compressed=False)
def test_what_scipy_writes_is_read(
    tmp_path: Path, arrays: dict[str, Any], fields: dict[str, Any], compressed: bool
) -> None:
    path = tmp_path / "a.mat"
    content = {**arrays, "Test": {**fields, "Inner": fields}, "Text": "words"}
    scipy.io.savemat(path, content, do_compression=compressed)
    found = {name: matlab5.whole(element) for name, element in matlab5.variables(path).items()}
    assert list(found) == list(content)
    for name, value in arrays.items():
        same(found[name].numbers(), value)
    for name, value in fields.items():
        for holder in (found["Test"], found["Test"].field("Inner")):
            inside = holder.field(name)
            assert inside is not None
            same(inside.numbers(), value)
    assert found["Test"].field("Nothing") is None
    assert found["Text"].numbers() is None


def same(found: NDArray[Any] | None, value: NDArray[Any]) -> None:
    assert found is not None
    np.testing.assert_array_equal(found, value)


def test_files_of_machines_with_the_other_order_of_bytes_are_read(tmp_path: Path) -> None:
    def element(kind: int, data: bytes) -> bytes:
        return struct.pack(">II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    numbers = np.array([[1.0, 2.5, -3.0]])
    inside = element(6, struct.pack(">II", 6, 0)) + element(5, struct.pack(">ii", 1, 3))
    inside += struct.pack(">HH4s", 1, 1, b"x") + element(9, numbers.astype(">f8").tobytes())
    (tmp_path / "a.mat").write_bytes(b" " * 124 + struct.pack(">H", 0x0100) + b"MI" + element(14, inside))
    (found,) = matlab5.variables(tmp_path / "a.mat").values()
    same(matlab5.whole(found).numbers(), numbers)
    same(scipy.io.loadmat(tmp_path / "a.mat")["x"], numbers)


def saved(path: Path, compressed: bool) -> bytes:
    amplitude = np.linspace(1, 2, 5) * np.exp(1j)
    content = {"frequency": np.arange(5.0), "test": {"tip": amplitude, "force": np.ones(5)}, "note": "by a test"}
    scipy.io.savemat(path, content, do_compression=compressed)
    return path.read_bytes()


CHANGES = st.lists(st.tuples(st.integers(0, 2000), st.binary(min_size=0, max_size=6)), min_size=1, max_size=4)


@settings(SAME_FOLDER, max_examples=400)
@given(compressed=st.booleans(), changes=CHANGES, kept=st.floats(0, 1), cut=st.booleans())
def test_damaged_files_are_refused_or_read(
    tmp_path: Path, compressed: bool, changes: list[tuple[int, bytes]], kept: float, cut: bool
) -> None:
    """In this process, which scipy's reader would have ended: bytes written over, and the end cut off."""
    path = tmp_path / "a.mat"
    content = bytearray(saved(path, compressed))
    for place, written in changes:
        at = 120 + place % (len(content) - 120)
        content[at : at + len(written)] = written
    path.write_bytes(bytes(content[: int(kept * len(content))] if cut else content))
    with contextlib.suppress(MeasurementError):
        (sweep,) = read_matlab(path, ("test.tip", "test.force"), MatlabOptions())
        assert all(channel.amplitude.shape[1] == len(sweep.frequency) for channel in sweep.channels.values())


@pytest.mark.parametrize("compressed", [False, True])
def test_it_is_said_what_is_damaged(tmp_path: Path, compressed: bool) -> None:
    path = tmp_path / "a.mat"
    content = saved(path, compressed)
    path.write_bytes(content[:-30])
    with pytest.raises(MeasurementError, match=r"damaged or no MATLAB file \(an element of \d+ bytes is stated"):
        read_matlab(path, ("test.tip",), MatlabOptions())
    path.write_bytes(b"no MATLAB file" * 20)
    with pytest.raises(MeasurementError, match="its header is not that of MATLAB 5 to 7"):
        read_matlab(path, ("test.tip",), MatlabOptions())
