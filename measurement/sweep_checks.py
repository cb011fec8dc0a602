"""What a sweep must be before anything is computed from it: finite, ordered, driven, and in agreement with itself."""

from dataclasses import replace

import numpy as np

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import label_factor, quantity_of_label, si_factor, unit_and_kind
from updamp.measurement.recorded import Complex, Floats, RecordedChannel, RecordedSweep
from updamp.rig.fields import LOGARITHMIC, Quantity, is_logarithmic

LEVEL_TOLERANCE = 0.25  # of the median measured against the stated level; RMS taken for peak is off by 0.29


def check_frequencies(where: str, frequency: Floats) -> None:
    """raises: MeasurementError where there are fewer than two, or they are not finite, positive, distinct and in
    order"""
    if len(frequency) == 0:
        raise MeasurementError(f"{where}: no frequencies; leave the run out or export it again")
    if len(frequency) == 1:
        raise MeasurementError(
            f"{where}: {frequency[0]:g} Hz alone is no sweep, a run has two frequencies at least; add its other "
            "points, or leave it out and state what it tells as a feature"
        )
    bad = ~(np.isfinite(frequency) & (frequency > 0))
    if bad.any():
        raise MeasurementError(f"{where}: frequency = {frequency[bad][0]:g} Hz at place {np.argmax(bad) + 1}; mend it")
    steps = np.sign(np.diff(frequency))
    same_way = (steps == steps[:1]) & (steps != 0)
    if same_way.all():
        return
    i = int(np.argmin(same_way))
    if steps[i] == 0:
        raise MeasurementError(
            f"{where}: frequency = {frequency[i]:g} Hz stands there twice, at places {i + 1} and {i + 2}; average the "
            f"two, or take one out"
        )
    raise MeasurementError(
        f"{where}: frequencies turn round at {frequency[i]:g} Hz, place {i + 1}; a run is one sweep one way: split the "
        f"file, or tell its sweeps apart by a column of runs, repeats or directions (long_csv: run, repeat, sweep; "
        f'csv_columns: options = {{ run = "its column" }}, repeat or sweep likewise)'
    )


def check_channel(where: str, channel: RecordedChannel, frequency: Floats) -> None:
    """raises: MeasurementError where an amplitude or its noise is not finite"""
    if 1 not in channel.harmonics:
        raise MeasurementError(f"{where}: harmonics = {channel.harmonics}: 1, that of the excitation, is missing")
    bad = ~np.isfinite(channel.amplitude)
    if bad.any():
        k, i = np.argwhere(bad)[0]
        raise MeasurementError(
            f"{where}: {bad.sum()} of {bad.size} values are no finite numbers, the first {channel.amplitude[k, i]} at "
            f"{frequency[i]:g} Hz, harmonic {channel.harmonics[k]}; take these frequencies out of the file or mend it"
        )
    if channel.noise is not None and not (np.isfinite(channel.noise).all() and (channel.noise >= 0).all()):
        raise MeasurementError(f"{where}: its noise has values that are negative or no finite numbers; mend the file")


def check_not_zero(where: str, channel: RecordedChannel, frequency: Floats) -> None:
    """raises: MeasurementError where the first harmonic of a response is zero: ratios of amplitudes are compared"""
    zero = channel.amplitude[channel.harmonics.index(1)] == 0
    if zero.any():
        raise MeasurementError(
            f"{where}: response = 0 at {zero.sum()} of {len(zero)} frequencies, the first {frequency[zero][0]:g} Hz; "
            f"no sensor that works reads exactly that: leave the channel out (channels of the run), or take these "
            f"frequencies out of the file"
        )


def check_magnitudes(where: str, channel: RecordedChannel, frequency: Floats) -> None:
    """raises: MeasurementError where a channel of amplitudes alone has one that is negative"""
    values = channel.amplitude[channel.harmonics.index(1)]
    negative = (values.real < 0) & ~values.imag.any()
    if negative.any():
        i = int(np.argmax(negative))
        raise MeasurementError(
            f'{where}: with phase = "none" its values are amplitudes, and {negative.sum()} of {len(values)} are '
            f"negative, the first {values[i].real:g} at {frequency[i]:g} Hz; mend them, make amplitudes of values in "
            f'dB (10^(dB/20) of their reference), or take phase = "none" out where the signs mean something'
        )


def check_force(where: str, force: Complex, frequency: Floats) -> None:
    """raises: MeasurementError where it is zero: nothing can be divided by it"""
    zero = np.abs(force) == 0
    if zero.any():
        raise MeasurementError(
            f"{where}: force = 0 at {zero.sum()} of {len(force)} frequencies, the first {frequency[zero][0]:g} Hz; the "
            f"force is taken as measured at each frequency: check the load cell's channel, or take these lines out"
        )


def check_level(where: str, level: float, measured: Floats, unit: str) -> None:
    """raises: MeasurementError where what was held is not near its level: then one of them is not what it seems"""
    median = float(np.median(measured))
    if not abs(median / level - 1) <= LEVEL_TOLERANCE:
        hint = " (a factor of 1.41: RMS for peak?)" if 1.35 < max(median / level, level / median) < 1.48 else ""
        raise MeasurementError(
            f"{where}: level = {level:g} {unit} but the median of the measured peak values is {median:g} {unit}{hint}; "
            f'state the level as a peak value, correct unit or amplitude, or state held = "nothing"'
        )


def check_power(where: str, displacement: Complex, force: Complex, angular_frequency: Floats, convention: str) -> None:
    """At the excitation itself the force feeds the structure: the displacement lags, Im(x conj(F)) < 0 on the whole.

    convention: as it is stated, or taken to be
    raises: MeasurementError where the structure would feed the shaker
    """
    power = -0.5 * angular_frequency * np.imag(displacement * np.conj(force))
    if float(power.sum()) < 0:
        other = "exp(+iwt)" if convention == "exp(-iwt)" else "exp(-iwt)"
        raise MeasurementError(
            f"{where}: at the point of excitation the structure would feed the shaker ({power.sum() / len(power):.3g} "
            f'W on average): the sign of direction is wrong, or time_convention = "{other}" holds, or '
            f'the phase is another quantity\'s than the amplitude (phase_of = "displacement")'
        )


def turned_as_stated(where: str, channel: RecordedChannel, direction: str) -> tuple[RecordedChannel, list[str]]:
    """With the sign that the file's own minus asks for, and what was done or taken for granted for that.

    A plus is what programs write where nobody set a direction: it gives way to a minus in measurement.toml.
    """
    wanted = (direction if direction[0] in "+-" else f"+{direction}").upper()
    if channel.direction in ("", wanted):
        return channel, []
    if channel.direction[1:] != wanted[1:] or channel.direction[0] == "+":
        note = f"{where}: the file's direction {channel.direction} is taken for the model's {wanted.lower()}"
        return channel, [note]
    note = f"{where}: the file's direction {channel.direction} is opposite to {wanted.lower()}; its sign is turned"
    return replace(channel, amplitude=-channel.amplitude, direction=wanted), [note]


def check_statements(
    where: str, channel: RecordedChannel, quantity: str, unit: str, told: str = "", amplitude: str | None = None
) -> list[str]:
    """What the file says of its channel against measurement.toml; returns what was taken for granted.

    told: what its reader said of the channel; amplitude: stated, None where nothing is
    raises: MeasurementError where quantity, unit or amplitude contradict each other
    """
    notes = []
    label, kind = unit_and_kind(channel.unit)
    if kind and amplitude and kind != amplitude:
        raise MeasurementError(
            f'{where}: the file says {channel.unit}, measurement.toml amplitude = "{amplitude}"; correct one of them'
        )
    if channel.quantity not in ("", quantity):
        raise MeasurementError(
            f'{where}: the file says {channel.quantity}, measurement.toml quantity = "{quantity}"; correct one of them'
        )
    if channel.unit:
        try:
            stated = label_factor(label, quantity)
        except ValueError:
            if is_logarithmic(label):
                raise MeasurementError(f"{where}: the file says {channel.unit}, which {LOGARITHMIC}") from None
            if other := quantity_of_label(label):
                raise MeasurementError(
                    f"{where}: the file says {channel.unit}, the unit of a {other}; measurement.toml quantity = "
                    f'"{quantity}", unit = "{unit}"; correct one of them{f" ({told})" if told else ""}'
                ) from None
            notes.append(f"{where}: the file's unit '{channel.unit}' is not understood; {unit} is taken")
        else:
            if not np.isclose(stated, si_factor(unit, quantity), rtol=1e-6):
                raise MeasurementError(
                    f'{where}: the file says {channel.unit}, measurement.toml unit = "{unit}"; correct one of them'
                    f"{f' ({told})' if told else ''}"
                )
    return notes


def check_own_unit(where: str, channel: RecordedChannel, unit: str) -> None:
    """Of a channel that is not calibrated. raises: MeasurementError where the file has a multiple of the unit stated"""
    try:
        factor = Quantity(unit, f"1 {unit}").to_si(f"1 {channel.unit}")
    except Exception:  # none, or one of the maker's own, over which the parser of units may stumble in any way
        return
    if not np.isclose(factor, 1, rtol=1e-6):
        raise MeasurementError(
            f'{where}: the file says {channel.unit}, measurement.toml unit = "{unit}"; correct one of them'
        )


def in_order_of_the_sweep(where: str, sweep: RecordedSweep, stated: str) -> tuple[bool, bool, list[str]]:
    """(upwards, whether the file has the reverse order, what was taken for granted).

    raises: MeasurementError where a sweep "up" is stored downwards
    """
    ascending = bool(sweep.frequency[1] > sweep.frequency[0])
    if not stated:
        word = "up" if ascending else "down"
        return ascending, False, [f"{where}: the direction of the sweep is not stated; {word}, as the file's order is"]
    if stated == "up" and not ascending:
        raise MeasurementError(f'{where}: sweep = "up" but the frequencies fall; state sweep = "down"')
    if stated == "down" and ascending:
        note = f"{where}: the frequencies of this downward sweep rise in the file; taken as sorted by the recorder"
        return False, True, [note]
    return stated == "up", False, []
