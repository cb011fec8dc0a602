"""What measurement.toml may not state of time signals: samples are no complex amplitudes."""

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.measurement_file import MeasurementFile
from updamp.measurement.tables import RunTable


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
        if table.per_force:
            raise MeasurementError(
                f"{where}: channels.{name}.per_force = true: {what}; samples are not divided by the force: take the "
                f"line out"
            )
        if table.amplitude not in (None, "peak"):
            raise MeasurementError(
                f'{where}: channels.{name}.amplitude = "{table.amplitude}": {what}; samples are instantaneous values: '
                f'state amplitude = "peak"'
            )


def phases_not_used(file: MeasurementFile, run: RunTable) -> str:
    """What the run's options give of channels that are stated to have no phase; "" where nothing."""
    silent = {file.label(name) for name, channel in file.channels.items() if channel.phase == "none"}
    keys = [f"options.{key}" for key in ("phase", "imaginary") if silent & set(run.options.get(key, ()))]
    told = 'is not used for channels of phase = "none"; take that line out of the channel to use it'
    return f"{' and '.join(keys)} {told}" if keys else ""
