"""Frequency response functions: responses divided by a force, which they are to be multiplied by again."""

from dataclasses import dataclass

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import label_factor
from updamp.measurement.recorded import RecordedChannel
from updamp.measurement.tables import ChannelTable


@dataclass(frozen=True, eq=False)
class FrequencyResponse(RecordedChannel):
    """Divided by the force, peak by peak or RMS by RMS, which is the same.

    force_unit, reference: unit and direction of that force as the file says, such as "lbf", "-X"; "" where it does not
    """

    per_force: bool = True
    force_unit: str = ""
    reference: str = ""


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
        raise MeasurementError(
            f'{where}: the unit of the force it is divided by, "{label}" (record 10 of data set 58), is not '
            f"understood; write it there as N, kN or lbf"
        ) from None
