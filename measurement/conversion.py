"""A recorded sweep to a measured run: displacement, peak, SI, positive as the model has it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from updamp.measurement.measurement import MeasuredRun, MeasurementError, near
from updamp.measurement.measurement_file import MeasurementFile
from updamp.measurement.per_force import divisor
from updamp.measurement.quantities import AMPLITUDES, QUANTITIES, to_displacement
from updamp.measurement.recorded import Complex, Floats, RecordedChannel, RecordedSweep
from updamp.measurement.sweep_checks import (
    check_channel,
    check_force,
    check_frequencies,
    check_level,
    check_magnitudes,
    check_not_zero,
    check_own_unit,
    check_power,
    check_statements,
    in_order_of_the_sweep,
    turned_as_stated,
)
from updamp.measurement.tables import ChannelTable, RunTable, level_in_si


@dataclass(frozen=True, eq=False)
class Converted:
    """reading: in SI of its own quantity, peak; displacement [m], noise [m]: (n_harmonics, n)"""

    reading: Complex
    displacement: Complex
    noise: Floats | None


def measured_run(
    path: Path, file: MeasurementFile, run: RunTable, sweep: RecordedSweep, repeat: int
) -> tuple[MeasuredRun, list[str]]:
    """The run and what was taken for granted, in sentences. path: of the data file

    raises: MeasurementError naming file, run, channel and value where the data cannot be used
    """
    where = f"{path}: run '{run.name}'"
    names = [name for name in run.channels or tuple(file.channels) if name != file.force_channel]
    # First: a sweep has no frequencies where the file has none of the labels.
    recorded, granted = _all_recorded(where, file, run, sweep, names)
    check_frequencies(where, sweep.frequency)
    upwards, reverse, notes = in_order_of_the_sweep(where, sweep, run.sweep or sweep.sweep)
    order = slice(None, None, -1 if reverse else 1)
    notes += granted
    force = _force(where, file, recorded[file.force_channel], sweep.frequency)
    harmonics, kept = _common_harmonics(where, file, recorded)
    converted, taken = _all_converted(where, file, recorded, harmonics, force, sweep.frequency)
    notes += [*taken, *kept]
    level, level_notes = _level(where, file, run, force, converted, harmonics)
    unit = QUANTITIES[file.channels[run.held_channel].quantity].si if run.held_channel else "N"
    measured = MeasuredRun(
        name=run.name,
        mode=run.mode,
        upwards=upwards,
        held=run.held,
        level=level,
        repeat=repeat,
        channels=tuple(names),
        harmonics=harmonics,
        frequency=sweep.frequency[order],
        force=force[order],
        response=np.array([converted[name].displacement[:, order] for name in names]),
        noise=_noise(where, converted, order),
        level_unit=unit,
        held_channel=run.held_channel or "",
        without_phase=tuple(name for name in names if file.channels[name].phase == "none"),
        taken=run.taken or 0,
    )
    return measured, [*notes, *level_notes]


def _all_recorded(
    where: str, file: MeasurementFile, run: RunTable, sweep: RecordedSweep, names: Sequence[str]
) -> tuple[dict[str, RecordedChannel], list[str]]:
    """Channels of the names and the force's, and what was taken for granted of them."""
    recorded = {name: _recorded(where, file, sweep, name) for name in names}
    recorded[file.force_channel], notes = _recorded_force(where, file, run, sweep)
    notes += _checked(where, file, sweep, recorded)
    for name, channel in recorded.items():
        here = f"{where} channel '{name}'"
        recorded[name], turned = turned_as_stated(here, channel, file.channels[name].direction)
        notes += turned
    return recorded, notes


def _checked(
    where: str, file: MeasurementFile, sweep: RecordedSweep, recorded: dict[str, RecordedChannel]
) -> list[str]:
    """What was taken for granted of the channels, all of them finite and as measurement.toml says."""
    notes = []
    for name, channel in recorded.items():
        here, table = f"{where} channel '{name}'", file.channels[name]
        check_channel(here, channel, sweep.frequency)
        if name != file.force_channel:
            check_not_zero(here, channel, sweep.frequency)
        if table.phase == "none":
            check_magnitudes(here, channel, sweep.frequency)
        if table.uncalibrated:
            stands_for = f"1 {table.unit} stands for 1 {QUANTITIES[table.quantity].si}"
            check_own_unit(here, channel, table.unit)
            notes.append(f"{here} is not calibrated: {stands_for}, and results are in {table.unit}")
        else:
            told = _told(sweep, file.label(name))
            notes += check_statements(here, channel, table.quantity, table.unit, told, table.amplitude)
    return notes


def _all_converted(
    where: str,
    file: MeasurementFile,
    recorded: dict[str, RecordedChannel],
    harmonics: tuple[int, ...],
    force: Complex,
    frequency: Floats,
) -> tuple[dict[str, Converted], list[str]]:
    """All channels but the force's, and what was taken for granted of them."""
    divided_by, taken = _divided_by(where, file, recorded, force)
    w = 2 * np.pi * frequency
    converted = {
        name: _converted(f"{where} channel '{name}'", file, name, channel, harmonics, divided_by.get(name), w)
        for name, channel in recorded.items()
        if name != file.force_channel
    }
    _check_power(where, file, converted, harmonics, force, w)
    return converted, taken


def _recorded(where: str, file: MeasurementFile, sweep: RecordedSweep, name: str) -> RecordedChannel:
    label = file.label(name)
    if label in sweep.channels:
        return sweep.channels[label]
    what = "the force, " if name == file.force_channel else ""
    if told := _told(sweep, label):
        raise MeasurementError(f"{where}: {what}channel '{name}' cannot be read: {told}")
    taken = f"all that it has are taken: {', '.join(sweep.channels)}" if sweep.channels else "it has no channel at all"
    free = near(label, sweep.others) if sweep.others else taken
    has = [n for n in file.channels if file.label(n) in sweep.channels and n != file.force_channel]
    remedy = f"correct its label, or name those that the run has: channels = {has}" if has else "correct its label"
    raise MeasurementError(
        f"{where}: {what}channel '{name}' (label = \"{label}\") is not in the file; {free}; {remedy}"
    )


def _told(sweep: RecordedSweep, label: str) -> str:
    """What the reader said of a label, such as why its record is not used."""
    return "; ".join(note for note in sweep.notes if f"'{label}'" in note)


def _recorded_force(
    where: str, file: MeasurementFile, run: RunTable, sweep: RecordedSweep
) -> tuple[RecordedChannel, list[str]]:
    """As in the file, or the run's level where it was not recorded; and what was taken for granted."""
    table = file.channels[file.force_channel]
    if table.recorded:
        return _recorded(where, file, sweep, file.force_channel), []
    level = (level_in_si(file.channels, run) or 0.0) / _factor(table)
    amplitude = np.full((1, len(sweep.frequency)), level, dtype=complex)
    return RecordedChannel(amplitude), [f"{where}: the force was not recorded; the level is taken at every frequency"]


def _force(where: str, file: MeasurementFile, channel: RecordedChannel, frequency: Floats) -> Complex:
    """Its first harmonic, peak, in N along the model's axis."""
    raw = _turned(file, channel.amplitude[channel.harmonics.index(1)])
    force = raw * _factor(file.channels[file.force_channel])
    check_force(where, force, frequency)
    return force


def _divided_by(
    where: str, file: MeasurementFile, recorded: dict[str, RecordedChannel], force: Complex
) -> tuple[dict[str, Complex], list[str]]:
    """Of each frequency response function the peak force in its own unit and direction; what was taken for granted."""
    table, direction = file.channels[file.force_channel], recorded[file.force_channel].direction
    as_read = -force if table.negative else force
    forces: dict[str, Complex] = {}
    notes = []
    for name, channel in recorded.items():
        if channel.per_force and name != file.force_channel:
            newtons, taken = divisor(f"{where} channel '{name}'", channel, table, direction)
            forces[name] = as_read / newtons
            notes += taken
    return forces, notes


def _factor(table: ChannelTable, sort: str | None = None) -> float:
    """From the reading to a peak value in SI, positive along the model's axis."""
    peak = AMPLITUDES[sort or table.amplitude or "peak"]
    return table.si_factor * peak * (-1.0 if table.negative else 1.0)


def _turned(file: MeasurementFile, amplitude: Complex) -> Complex:
    return np.conj(amplitude) if file.time_convention == "exp(-iwt)" else amplitude


def _common_harmonics(
    where: str, file: MeasurementFile, recorded: dict[str, RecordedChannel]
) -> tuple[tuple[int, ...], list[str]]:
    """Those that every sensor has; a mean position is known to displacement sensors only."""
    sets = []
    for name, channel in recorded.items():
        if name != file.force_channel:
            static = QUANTITIES[file.channels[name].quantity].derivatives == 0
            sets.append({k for k in channel.harmonics if k > 0 or static})
    common = tuple(sorted(set.intersection(*sets)))
    left_out = sorted(
        {k for name, c in recorded.items() if name != file.force_channel for k in c.harmonics} - set(common)
    )
    if not left_out:
        return common, []
    return common, [f"{where}: harmonics {left_out} are left out: not every channel has them as a displacement"]


def _converted(
    where: str,
    file: MeasurementFile,
    name: str,
    channel: RecordedChannel,
    harmonics: Sequence[int],
    divided_by: Complex | None,
    w: Floats,
) -> Converted:
    table = file.channels[name]
    rows = [channel.harmonics.index(k) for k in harmonics]
    amplitude = _turned(file, channel.amplitude[rows])
    size = np.ones((1, len(w)))
    sort = table.amplitude
    if divided_by is not None:
        if tuple(harmonics) != (1,):
            raise MeasurementError(f"{where}: a frequency response function has harmonic 1 only, here are {harmonics}")
        amplitude, size, sort = amplitude * divided_by, np.abs(divided_by)[None], "peak"  # as the force is by now
    at = np.array(harmonics)[:, None] * w
    factor = np.where(at > 0, _factor(table, sort), _factor(table, "peak"))  # a mean value is neither RMS nor peak
    displacement = to_displacement(amplitude * factor, at, table.quantity, table.phase_of)
    derivatives = QUANTITIES[table.quantity].derivatives or 0
    noise: Floats | None = None
    if table.noise is not None:
        noise = table.to_si(table.noise) * AMPLITUDES[table.amplitude or "peak"] / at**derivatives
    elif channel.noise is not None:
        noise = channel.noise[rows] * size * np.abs(factor) / at**derivatives
    return Converted(amplitude * factor, displacement, noise)


def _check_power(
    where: str,
    file: MeasurementFile,
    converted: dict[str, Converted],
    harmonics: Sequence[int],
    force: Complex,
    w: Floats,
) -> None:
    """Where the sensor is that moves with the force."""
    for name, channel in converted.items():
        if file.channels[name].model_point == file.excitation and file.channels[name].phase is None:
            check_power(
                f"{where} channel '{name}'",
                channel.displacement[harmonics.index(1)],
                force,
                w,
                file.time_convention or "exp(+iwt)",
            )


def _noise(where: str, converted: dict[str, Converted], order: slice) -> Floats | None:
    known = {name: part.noise[:, order] for name, part in converted.items() if part.noise is not None}
    if not known:
        return None
    if unknown := [name for name in converted if name not in known]:
        raise MeasurementError(
            f"{where}: the noise of {', '.join(known)} is known, that of {', '.join(unknown)} is not; state it for all "
            f'channels, such as noise = "0.2 um/s"'
        )
    return np.array(list(known.values()))


def _level(
    where: str,
    file: MeasurementFile,
    run: RunTable,
    force: Complex,
    converted: dict[str, Converted],
    harmonics: tuple[int, ...],
) -> tuple[float, list[str]]:
    level = level_in_si(file.channels, run)
    if level is None:
        level = float(np.median(np.abs(force)))
        return level, [f"{where}: nothing was held; its level is the median of the measured force, {level:.3g} N"]
    if run.held == "force":
        check_level(where, level, np.abs(force), "N")
    if run.held_channel is not None:
        reading = converted[run.held_channel].reading[harmonics.index(1)]
        check_level(where, level, np.abs(reading), QUANTITIES[file.channels[run.held_channel].quantity].si)
    return level, []
