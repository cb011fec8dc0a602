"""Is the measurement in the units it says, and of this rig? Asked before anything is fitted to it.

Where units are mistaken a measurement is off by a factor that one knows: 1000, 9.81, 1.414, 2 pi. Frequencies are held
against those at which the model can resonate, amplitudes and signs against its modal constant
(`workflow/modal_constant.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.findings.backbone import half_power_frequency
from updamp.comparison.findings.tops import highest, tops
from updamp.comparison.fit.observations import relative_deviation
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.small_amplitude import SmallAmplitude
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement, MeasurementError
from updamp.model.calibration import PRELOAD
from updamp.model.small_amplitude import numbers_by_name, small_amplitude
from updamp.rig.questions import possible_resonances
from updamp.workflow.modal_constant import StraightLine, modal_fit

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class QuestionOptions:
    """frequency: how far a measured resonance may lie from where the model can resonate; a modulus that is wrong by
    half gives as much
    exact: how close to a known factor an amplitude is for it to be asked about; odd: a factor that is asked about in
    any case: mode shapes are hardly wrong by as much
    turned: of a quarter of a turn, by which an oscillator's phase turns between its half-power points, the least and
        the most (all changes added up) that nothing is asked about: where a sweep jumps it turns by up to two quarters,
        or by less than one; half a turn in radians, taken for degrees, is a thirtieth of a quarter
    """

    frequency: float = 0.2
    exact: float = 0.06
    odd: float = 5.0
    turned: tuple[float, float] = (0.1, 3.0)


FREQUENCY_UNITS = {"kHz": 1e3, "mHz": 1e-3, "rad/s": 1 / (2 * np.pi), "1/min": 1 / 60}
UNIT = "channels.{}.unit"
# What a reading is too large by, or too small by, and what it may be.
FACTORS = {
    1e3: 'millimetres taken for metres or the other way round ("mm/s" and "m/s"), or kN for N; correct {unit}',
    1e6: 'micrometres taken for metres or the other way round ("um/s" and "m/s"); correct {unit}',
    10.0: "the range of an amplifier, or a sensitivity ten times off; correct the data or {unit}",
    100.0: "the range of an amplifier, or a sensitivity a hundred times off; correct the data or {unit}",
    np.sqrt(2): 'RMS taken for peak or the other way round; correct channels.{name}.amplitude ("rms", "peak")',
    2.0: 'peak to peak taken for peak or the other way round; correct channels.{name}.amplitude ("peak_to_peak")',
    2 * np.pi: "2 pi: frequencies in Hz taken for rad/s where the recorder integrated; correct the data or {unit}",
}  # fmt: skip


OF_ACCELERATIONS = {
    9.80665: 'multiples of standard gravity taken for m/s^2 or the other way round ("g_0", "m/s^2"); correct {unit}',
}


def unknown_modes(measurement: Measurement, modes: Sequence[str]) -> list[str]:
    """Questions on the modes that runs name, spaces for underscores. modes: of the study, or those of the rig file"""
    return [
        f'mode = "{mode}" is none of the rig file\'s ({", ".join(modes)}); {_near(mode, modes)}'
        for mode in dict.fromkeys(run.mode for run in measurement.runs)
        if mode.replace(" ", "_") not in modes
    ]


def another_pull(measurement: Measurement, pull: float) -> list[str]:
    """A question where the damper was pulled by another force than the rig file states, beyond what the preload is
    unsure by. pull: that one [N]"""
    if not abs(measurement.pull - pull) > PRELOAD.deviation * pull:  # nan: none is stated
        return []
    return [
        f"damper_load = {measurement.pull:g} N, and the rig file has load.pull = {pull:g} N, by which the model is "
        "pulled; which one is right?"
    ]


def _near(mode: str, modes: Sequence[str]) -> str:
    close = get_close_matches(mode, modes, n=1)
    return f"did you mean {close[0]}?" if close else "is it measured on this rig?"


def measured_against_model(model: RigModel, measurement: Measurement) -> list[str]:
    """Questions on units and signs, each with what may be meant. model: with the effects of its rig file

    raises: MeasurementError where the model is excited elsewhere, or a run has no frequency at which it can resonate:
        nothing could be compared
    """
    check_excitation(model.excitation, measurement)
    questions: list[str] = []
    runs = {run.name: run for run in reversed(measurement.runs)}  # one of each test
    enough = [run for run in reversed(runs.values()) if len(run) >= StraightLine.points]
    questions += [_few(run, StraightLine.points) for run in runs.values() if len(run) < StraightLine.points]
    questions += [text for run in enough if (text := _largest_at_an_end(run))]
    if enough:
        near = float(np.median([_peak(run) for run in enough]))
        found = small_amplitude(model, near)
        for run in enough:
            _check_frequency(run, _resonances(model, found))
        for channel in measurement.channels:
            questions += _of_channel(model, found, _lowest_of_modes(enough), channel)
    return questions


def _lowest_of_modes(runs: Sequence[MeasuredRun]) -> list[MeasuredRun]:
    """The lowest level of each mode, the lowest of all first."""
    lowest: dict[str, MeasuredRun] = {}
    for run in sorted(runs, key=lambda run: run.level):
        lowest.setdefault(run.mode, run)
    return list(lowest.values())


def _of_channel(model: RigModel, found: SmallAmplitude, runs: Sequence[MeasuredRun], channel: Channel) -> Iterator[str]:
    """Each kind of question once, of the first run that it is asked of: two sensors that are exchanged are right in the
    modes in which both move alike."""
    asked: set[str] = set()
    for run in runs:
        if channel.name in run.channels:
            for kind, question in _channel(model, found, run, channel):
                if kind not in asked:
                    yield question
                asked.add(kind)


def check_excitation(point: str, measurement: Measurement) -> None:
    """point: of the model

    raises: MeasurementError where the measurement states another one
    """
    if measurement.excitation and measurement.excitation != point:
        raise MeasurementError(
            f'excitation = "{measurement.excitation}": the rig file excites the model at "{point}"; state '
            'the same there ([excitation] blade = "left" or "right"; excitation of a rig given by modes), or correct '
            "it here with the point of the force"
        )


def _few(run: MeasuredRun, points: int) -> str:
    return (
        f"run '{run.name}' has {len(run)} frequencies: fewer than {points} do not show a resonance (frequency, "
        "damping, height and phase); is the file whole?"
    )


def _largest_at_an_end(run: MeasuredRun) -> str:
    """Where every channel is highest at an end of the measured frequencies, and has no top that chance does not make
    between them; "" where one has"""
    for channel in run.channels:
        log_size = _log_size(run, channel)
        inner, _ = tops(log_size, relative_deviation(run, channel))
        if len(inner) or 0 < np.argmax(log_size) < len(log_size) - 1:
            return ""
    low, high = float(run.frequency.min()), float(run.frequency.max())
    return (
        f"run '{run.name}' has no resonance between {low:g} and {high:g} Hz, where it was measured: its response only "
        "rises or falls; what is said of its resonance is of the end that is highest; was it left out?"
    )


def _log_size(run: MeasuredRun, channel: str) -> Floats:
    """(n,) of the receptance; one that is zero somewhere is refused later on"""
    return np.asarray(np.log(np.maximum(np.abs(run.receptance(channel)), np.finfo(float).tiny)))


def _tops(run: MeasuredRun) -> list[float]:
    """Frequencies [Hz] at which a channel has its highest top, or is highest"""
    sizes = [(_log_size(run, channel), relative_deviation(run, channel)) for channel in run.channels]
    return [float(run.frequency[highest(size, deviation)]) for size, deviation in sizes]


def _peak(run: MeasuredRun) -> float:
    """Frequency [Hz] at which the strongest channel is highest."""
    receptances = np.abs([run.receptance(channel) for channel in run.channels])
    place = np.unravel_index(int(np.argmax(receptances)), receptances.shape)
    return float(run.frequency[place[1]])


def _resonances(model: RigModel, found: SmallAmplitude) -> list[tuple[float, float]]:
    """Where the model can resonate [Hz]."""
    free = model.components.frequencies[np.array(model.owner) != "damper"]
    return possible_resonances(free.tolist(), found.frequencies.tolist())


def _check_frequency(run: MeasuredRun, resonances: Sequence[tuple[float, float]]) -> None:
    off = QuestionOptions.frequency

    def possible(frequency: float) -> bool:
        return any(low * (1 - off) <= frequency <= high * (1 + off) for low, high in resonances)

    peak, (low, high) = _peak(run), (run.frequency.min(), run.frequency.max())
    within = any(one <= high and low <= other for one, other in resonances)
    # at an end of what was measured a response may be highest on the flank of another mode
    if any(map(possible, _tops(run))) or (within and _largest_at_an_end(run)):
        return
    meant = [unit for unit, factor in FREQUENCY_UNITS.items() if possible(peak * factor)]
    guess = (
        f"are its frequencies in {' or '.join(meant)} (a factor of {_sizes(meant)})? Convert them to Hz"
        if meant
        else "are its frequencies those of the test (column, unit, offset), and is it of this rig?"
    )
    nearest = min(resonances, key=lambda r: abs(np.log(r[1] / peak)))
    raise MeasurementError(
        f"run '{run.name}': the response is highest at {peak:.4g} Hz, and the model can resonate nowhere within "
        f"{100 * off:.0f} % of that, the nearest is {_range(nearest)}; {guess}"
    )


def _range(resonance: tuple[float, float]) -> str:
    low, high = resonance
    return f"{high:.2f} Hz" if high - low < 0.01 * high else f"{low:.1f} to {high:.1f} Hz"


def _sizes(units: Sequence[str]) -> str:
    return " or ".join(f"{max(f, 1 / f):.3g}" for f in (FREQUENCY_UNITS[unit] for unit in units))


def _channel(model: RigModel, found: SmallAmplitude, run: MeasuredRun, channel: Channel) -> Iterator[tuple[str, str]]:
    """Kinds of questions, and the questions."""
    name, point = channel.name, channel.point
    if name not in run.without_phase and (guess := _turn(run, name)):
        yield "turn", guess
    measured = modal_fit(run.frequency, run.receptance(name))
    if measured is None:
        return
    frequency = _peak(run)
    mode, certain = _mode_of(run, found, frequency)
    own = _own_constant(model, found, mode, run.frequency * found.frequencies[mode] / frequency, point)
    if own == 0:
        return
    where = f"channel '{name}' (run '{run.name}')"
    ratio = complex(measured.constant / own)
    if guess := _factor(channel, abs(ratio), frequency):
        size = f"its modal constant at {frequency:.4g} Hz is {abs(ratio):.3g} times the model's"
        yield "size", f"{where}: {size}; {guess}?"
    if name in run.without_phase:
        return
    if measured.pole.imag < 0:
        yield (
            "time",
            f"{where}: its phase rises through the resonance at {frequency:.4g} Hz, as of a structure that gives "
            'energy; is time_convention right ("exp(+iwt)", "exp(-iwt)"), and the sign of its phases?',
        )
    # nearer to a quarter of a turn than to none; and to half of one
    elif certain and np.pi / 4 < abs(np.angle(ratio)) <= 3 * np.pi / 4:
        ahead = np.angle(ratio) > 0
        yield (
            "quarter",
            f"{where}: its phase is {abs(np.degrees(np.angle(ratio))):.0f} degrees {'ahead of' if ahead else 'behind'} "
            f"the model's at the resonance at {frequency:.4g} Hz, a quarter of a turn or nearly, as that of "
            f"{'a velocity' if ahead else 'a motion that was integrated once more'} is; are "
            f"channels.{name}.quantity and what its phase is measured against right (channels.{name}.phase_of)?",
        )
    elif certain and abs(np.angle(ratio)) > 3 * np.pi / 4:
        yield (
            "sign",
            f"{where}: it moves against the model at the resonance at {frequency:.4g} Hz; is "
            f"channels.{name}.direction right (with a minus sign where the sensor looks the other way), its point (two "
            f'sensors, or their phases, exchanged?), and mode = "{run.mode}"?',
        )


def _own_constant(model: RigModel, found: SmallAmplitude, mode: int, frequency: Floats, point: str) -> complex:
    """The model's, read off its own response at so many frequencies [Hz] as the measured one is, since other modes
    have a part in it; where it cannot be read so, the product of its shape's entries, or 0 where they have."""
    products = found.shapes[found.free.row(point)] * found.shapes[found.free.row(model.excitation)]
    own = complex(products[mode])
    if own == 0:
        return own
    read = modal_fit(frequency, np.sum(products / (found.squared - (2 * np.pi * frequency[:, None]) ** 2), axis=1))
    if read is not None:
        return read.constant
    there = found.squared[mode].real
    others = sum(products[i] / (found.squared[i] - there) for i in range(len(products)) if i != mode)
    alone = abs(others * (found.squared[mode] - there)) <= QuestionOptions.exact * abs(own)
    return own if alone else 0j


def _turn(run: MeasuredRun, name: str) -> str:
    """What the phase's unit may be where it hardly turns through a resonance, or wildly; "" where there is nothing to
    ask, or half of the height is not reached on both sides."""
    order = np.argsort(run.frequency)
    frequency, receptance = run.frequency[order], run.receptance(name)[order]
    size = np.abs(receptance)
    top = highest(_log_size(run, name)[order], relative_deviation(run, name)[order])
    low, high = (half_power_frequency(frequency, size, top, side) for side in (-1, 1))
    if np.isnan([low, high]).any():
        return ""
    before, after = np.searchsorted(frequency, low, "right") - 1, np.searchsorted(frequency, high)
    turns = np.diff(np.unwrap(np.angle(receptance[before : after + 1]))) / (np.pi / 2)
    least, most = QuestionOptions.turned
    if abs(turns.sum()) >= least and np.abs(turns).sum() <= most:
        return ""
    how, unit = (
        (f"turns by {90 * abs(turns.sum()):.2g} degrees", "radians taken for degrees")
        if np.abs(turns).sum() <= most
        else ("leaps to and fro", "degrees taken for radians")
    )
    return (
        f"channel '{name}' (run '{run.name}'): its phase {how} between {frequency[before]:.4g} and "
        f"{frequency[after]:.4g} Hz, through a resonance where it turns by 90 at least; are its phases {unit}, or "
        "without meaning?"
    )


def _mode_of(run: MeasuredRun, found: SmallAmplitude, frequency: float) -> tuple[int, bool]:
    """Number of the mode that a run's resonance is, and whether that is certain: by its name, or since no other is so
    near that the resonance may be its. The signs of another one's shape are other ones."""
    named = numbers_by_name(found)
    if run.mode in named:
        return named[run.mode], True
    mode = int(np.argmin(np.abs(found.frequencies - frequency)))
    apart = np.abs(np.delete(found.frequencies, mode) / found.frequencies[mode] - 1)
    return mode, bool((apart > QuestionOptions.frequency).all())


def _factor(channel: Channel, ratio: float, frequency: float) -> str:
    """What a modal constant that is so many times the model's may come from, "" where that is nothing to ask about."""
    size, name = max(ratio, 1 / ratio), channel.name
    w = 2 * np.pi * frequency
    known = FACTORS | (OF_ACCELERATIONS if channel.quantity in ("acceleration", "") else {})
    known |= {
        w: "velocity taken for displacement, or acceleration for velocity; correct channels.{name}.quantity",
        w**2: "acceleration taken for displacement; correct channels.{name}.quantity",
    }
    guesses = [
        f"a factor of {factor:.4g} is {text.format(unit=UNIT.format(name), name=name)}"
        for factor, text in known.items()
        if abs(np.log(size / factor)) < QuestionOptions.exact
    ]
    if not guesses and size <= QuestionOptions.odd:
        return ""
    return "; or ".join(guesses) or f"is {UNIT.format(name)} right, its quantity, and the point it looks at"
