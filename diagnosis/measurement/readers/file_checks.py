"""What every reader asks of a file before it opens it."""

from pathlib import Path

from updamp.diagnosis.measurement.measurement_errors import MeasurementError, near


def usable_file(path: Path, largest: float = float("inf")) -> None:
    """largest: size in bytes that the reader can hold in memory

    raises: MeasurementError where the file is missing, a folder, empty or too large
    """
    if not path.exists():
        beside = (file.name for file in path.parent.iterdir()) if path.parent.is_dir() else ()
        raise MeasurementError(f"{path}: no such file; beside measurement.toml {near(path.name, sorted(beside))}")
    if not path.is_file():
        raise MeasurementError(f"{path}: is a folder; name the data file itself")
    size = path.stat().st_size
    if size == 0:
        raise MeasurementError(f"{path}: the file is empty (0 bytes); export it again")
    if size > largest:
        raise MeasurementError(
            f"{path}: {size / 1e6:.0f} MB, more than the {largest / 1e6:.0f} MB that are read into memory; "
            f"split the file by run, or export amplitudes at the harmonics instead of time signals"
        )
