"""Readers register themselves."""

from pathlib import Path

import numpy as np
import pytest

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.hdf5 import write_hdf5
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.readers.registry import reader_of, readers, register
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedChannel, RecordedSweep


def test_files_in_the_folder_are_found() -> None:
    assert set(readers()) >= {"uff", "uff_time", "long_csv", "csv_columns", "time_csv", "matlab", "hdf5"}


def test_reader_by_ending_or_name() -> None:
    assert reader_of(Path("a.UNV"), None).name == "uff"
    assert reader_of(Path("a.csv"), "csv_columns").name == "csv_columns"
    with pytest.raises(MeasurementError, match=r"no reader for files ending in '\.xlsx' \(known are \.csv"):
        reader_of(Path("a.xlsx"), None)


def test_names_and_endings_are_taken_once() -> None:
    for name, endings in (("uff", ()), ("mine", (".mat",))):
        with pytest.raises(ValueError, match="is taken already"):
            register(name, endings)(reader_of(Path("a.mat"), None).read)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_uff_is_not_written_with_values_that_pyuff_would_change(tmp_path: Path, value: float) -> None:
    sweep = RecordedSweep("r", 1, "", np.array([1.0, 2.0]), {"a": RecordedChannel(np.array([[1 + 1j, value]]))})
    with pytest.raises(ValueError, match="not finite"):
        write_uff58(tmp_path / "a.uff", [sweep])


def test_noise_is_kept_or_refused(tmp_path: Path) -> None:
    channel = RecordedChannel(np.ones((1, 2), complex), noise=np.array([[0.1, 0.2]]))
    sweep = RecordedSweep("r", 1, "", np.array([1.0, 2.0]), {"a/b": channel})
    write_hdf5(tmp_path / "a.h5", [sweep])
    found = reader_of(Path("a.h5"), None).read(tmp_path / "a.h5", ("a/b",), None)[0].channels["a/b"].noise
    np.testing.assert_array_equal(found, [[0.1, 0.2]])
    with pytest.raises(ValueError, match="noise"):
        write_long_csv(tmp_path / "a.csv", [sweep])
    with pytest.raises(ValueError, match="noise"):
        write_uff58(tmp_path / "a.uff", [sweep])
