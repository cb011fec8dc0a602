"""Frequency response functions: responses divided by a force, which they are to be multiplied by again."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import is_over_force, label_factor, quantity_of_label
from updamp.measurement.recorded import RecordedChannel, RecordedSweep
from updamp.measurement.tables import ChannelTable

_WHAT = {True: "a response divided by the force", False: "a response itself, not divided by the force"}


@dataclass(frozen=True, eq=False)
class FrequencyResponse(RecordedChannel):
    """Divided by the force, peak by peak or RMS by RMS, which is the same.

    force_unit, reference: unit and direction of that force as the file says, such as "lbf", "-X"; "" where it does not
    """

    per_force: bool | None = True
    force_unit: str = ""
    reference: str = ""


def with_stated_ratios(where: str, sweep: RecordedSweep, tables: Mapping[str, ChannelTable]) -> RecordedSweep:
    """The sweep with its frequency response functions told from responses, by the file or else by measurement.toml.

    tables: of the channels wanted, by name
    raises: MeasurementError where the two contradict each other
    """
    channels = dict(sweep.channels)
    for name, table in tables.items():
        label = table.label or name
        if label in channels:
            channels[label] = _as_stated(f"{where} channel '{name}'", channels[label], table)
    return replace(sweep, channels=channels)


def _as_stated(where: str, channel: RecordedChannel, table: ChannelTable) -> RecordedChannel:
    if channel.per_force is not None:
        if table.per_force not in (None, channel.per_force):
            raise MeasurementError(
                f"{where}: per_force = {str(table.per_force).lower()}, but the file says that it is "
                f"{_WHAT[channel.per_force]} (the function type of a universal file, the attribute per_force of HDF5); "
                f"take per_force out of measurement.toml, or correct the file"
            )
        if channel.per_force and table.quantity == "force":
            raise MeasurementError(
                f"{where}: the file says that it is {_WHAT[True]}, so it is not the force; name the force's own "
                f"channel by its label, or state recorded = false where the file has none"
            )
        return channel
    above, below = _units_of_ratio(channel.unit)
    if not table.per_force and (below or is_over_force(channel.unit)):
        raise MeasurementError(
            f"{where}: the file says {channel.unit}, so it is {_WHAT[True]}; state unit = the response's unit alone, "
            f"and per_force = true"
        )
    if not table.per_force:
        return channel
    if not below and not table.uncalibrated and (quantity := quantity_of_label(channel.unit)):
        raise MeasurementError(
            f"{where}: per_force = true, but the file says {channel.unit}, the unit of a {quantity} that is not "
            f"divided by the force; take per_force out, or correct the file's unit (such as {channel.unit}/N)"
        )
    if not below:
        return replace(channel, per_force=True)
    return FrequencyResponse(
        channel.amplitude, channel.harmonics, channel.noise, True, above, channel.quantity, channel.direction, below
    )


def _units_of_ratio(label: str) -> tuple[str, str]:
    """Of response and force in a file's unit such as "(m/s²)/N"; ("", "") where it is no such ratio."""
    above, _, below = (part.strip("()[] ") for part in label.rpartition("/"))
    try:
        label_factor(below, "force")
    except ValueError:
        return "", ""
    return (above, below) if quantity_of_label(above) not in ("", "force") else ("", "")


def divisor(where: str, channel: RecordedChannel, table: ChannelTable, recorded: str) -> tuple[float, list[str]]:
    """[N] of the force as read that the channel is divided by, negative where that force points the other way; and
    what was taken for granted.

    table: of the force; recorded: direction of the force in the file, "" where it says nothing
    raises: MeasurementError where the file's unit of that force is not understood
    """
    if not isinstance(channel, FrequencyResponse):
        return table.si_factor, []
    factor, notes = _unit(where, channel.force_unit, table)
    own = recorded or (table.direction if table.direction[0] in "+-" else f"+{table.direction}").upper()
    if channel.reference in ("", own):
        return factor, notes
    if channel.reference[1] != own[1]:
        return factor, [*notes, f"{where}: its reference {channel.reference} is taken for the force's {own}"]
    note = f"{where}: its reference {channel.reference} is opposite to the force's {own}; its sign is turned"
    return -factor, [*notes, note]


def _unit(where: str, label: str, table: ChannelTable) -> tuple[float, list[str]]:
    if not label:
        return table.si_factor, [
            f"{where}: the unit of the force it is divided by is not stated; {table.unit} is taken"
        ]
    if table.uncalibrated:
        if label != table.unit:
            raise MeasurementError(
                f'{where}: it is divided by a force in "{label}", the force is uncalibrated in "{table.unit}"; both '
                f"have to be in one unit: export spectra instead"
            )
        return table.si_factor, []
    try:
        return label_factor(label, "force"), []
    except ValueError:
        if other := quantity_of_label(label):
            raise MeasurementError(
                f'{where}: the unit of the force it is divided by, "{label}" (record 10 of data set 58), is that of a '
                f"{other}; write it there as N, kN or lbf"
            ) from None
    return table.si_factor, [
        f"{where}: the unit of the force it is divided by, '{label}', is not understood; {table.unit} is taken"
    ]
