"""What measurement.toml may not state of time signals: samples are no complex amplitudes."""

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.measurement_file import MeasurementFile, RunTable


def check_samples(where: str, file: MeasurementFile, run: RunTable, reader: str) -> None:
    """raises: MeasurementError for a key on how amplitudes or phases came about: here the reader makes them"""
    what = f"{reader} reads time signals and computes peak amplitudes and phases itself"
    if file.time_convention == "exp(-iwt)":
        raise MeasurementError(
            f'{where}: time_convention = "exp(-iwt)": {what}; samples have no convention: take the line out'
        )
    for name in (file.force_channel, *(run.channels or file.channels)):
        table = file.channels[name]
        if not table.recorded:
            continue
        if table.phase_of is not None:
            raise MeasurementError(
                f'{where}: channels.{name}.phase_of = "{table.phase_of}": {what}; samples have no phase of another '
                f"quantity: take the line out"
            )
        if table.amplitude not in (None, "peak"):
            raise MeasurementError(
                f'{where}: channels.{name}.amplitude = "{table.amplitude}": {what}; samples are instantaneous values: '
                f'state amplitude = "peak"'
            )
