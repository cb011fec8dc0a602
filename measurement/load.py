"""From measurement.toml and the data files beside it to a `Measurement`."""

import hashlib
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from updamp.measurement.conversion import measured_run
from updamp.measurement.measurement import (
    DRIFT,
    FREQUENCY_ERROR,
    GAIN,
    LEVEL,
    Channel,
    Feature,
    MeasuredRun,
    Measurement,
    MeasurementError,
    near,
)
from updamp.measurement.measurement_file import (
    MeasurementFile,
    read_measurement_table,
    validated,
    with_defaults,
)
from updamp.measurement.overload import without_overload
from updamp.measurement.per_force import with_stated_ratios
from updamp.measurement.readers.registry import reader_of, usable_file
from updamp.measurement.recorded import RecordedSweep, one_way
from updamp.measurement.repeat_checks import check_numbers, copies
from updamp.measurement.sample_checks import check_samples, phases_not_used
from updamp.measurement.stated_features import is_feature_file, read_features
from updamp.measurement.tables import RunTable

FEW_REPEATS = 3  # assemblies; with fewer the scatter between them is hardly known


def load_measurement(path: str | Path, points: Sequence[str] | None = None, rig: str | None = None) -> Measurement:
    """Read and check a measurement: complex peak displacements and forces in SI, as exp(+i w t) has them.

    path: measurement.toml, or a file of stated features alone (damper load nan and excitation "" where it states none)
    points: names of the model's points, to check that each channel has one; rig: name of the rig compared with

    raises: MeasurementError naming the file, the value and the remedy
    """
    path = Path(path)
    table = read_measurement_table(path)
    files = _Files(path.parent)
    files.hash(path)
    if is_feature_file(table):
        measurement = _stated_only(path, table, files)
        _check_points(path, {"excitation": measurement.excitation} if measurement.excitation else {}, points)
        return measurement
    file = validated(path, with_defaults(path, table), MeasurementFile)
    if rig is not None and rig != file.rig:
        raise MeasurementError(
            f'{path}: rig = "{file.rig}" but it is compared with the rig "{rig}"; give that rig\'s file'
        )
    named = {f"channels.{name}.point": channel.model_point for name, channel in file.channels.items()}
    _check_points(path, {"excitation": file.excitation, **named}, points)
    return _with_runs(path, file, files)


@dataclass
class _Files:
    """Data files read so far: a file that holds several runs is read once."""

    folder: Path
    hashes: dict[str, str] = field(default_factory=dict)
    sweeps: dict[tuple[str, ...], tuple[RecordedSweep, ...]] = field(default_factory=dict)

    def hash(self, path: Path) -> None:
        name = str(path.relative_to(self.folder)) if path.is_relative_to(self.folder) else str(path)
        if name not in self.hashes:
            with path.open("rb") as file:
                self.hashes[name] = hashlib.file_digest(file, "sha256").hexdigest()

    def read(self, where: str, toml: Path, file: MeasurementFile, run: RunTable) -> tuple[RecordedSweep, ...]:
        data, labels = self.folder / run.file, file.labels
        usable_file(data)
        reader = reader_of(data, run.reader)
        if reader.of_samples:
            check_samples(f"{data}: run '{run.name}'", file, run, reader.name)
        options = validated(toml, run.options, reader.options, f"{where}.options.")
        key = (str(data), reader.name, options.model_dump_json(), *labels)
        if key not in self.sweeps:
            recorded = reader.read(data, labels, options)
            self.sweeps[key] = tuple(part for sweep in recorded for part in one_way(sweep))
            self.hash(data)
        return self.sweeps[key]


def _with_runs(path: Path, file: MeasurementFile, files: _Files) -> Measurement:
    runs, assumptions, questions = _runs(path, file, files)
    check_numbers(str(path), runs)
    if file.repeatability is not None and len(repeats := {run.repeat for run in runs}) > 1:
        raise MeasurementError(
            f"{path}: repeatability = {file.repeatability:g}: there are {len(repeats)} repeats among the runs, which "
            "tell it; take the line out"
        )
    return Measurement(
        title=file.title,
        pull=math.nan if file.damper_load is None else file.damper_load,
        excitation=file.excitation,
        channels=tuple(
            Channel(name, channel.model_point, channel.negative, channel.quantity)
            for name, channel in file.channels.items()
            if name != file.force_channel
        ),
        runs=runs,
        features=_features(file, files),
        assumptions=tuple(
            dict.fromkeys([*_conventions(file), *assumptions, *copies(str(path), runs), *_few_repeats(runs)])
        ),
        hashes=files.hashes,
        repeatability=file.repeatability or 0.0,
        questions=tuple(questions),
        drift=file.frequency_drift or DRIFT,
        gain=file.gain_error or GAIN,
        level=file.level_error or LEVEL,
        frequency_error=file.frequency_error or FREQUENCY_ERROR,
        units=_own_units(file),
    )


def _runs(path: Path, file: MeasurementFile, files: _Files) -> tuple[tuple[MeasuredRun, ...], list[str], list[str]]:
    """The runs, what was taken for granted, and what is to be asked about."""
    times = Counter(run.name for run in file.runs)
    runs: list[MeasuredRun] = []
    assumptions: list[tuple[str, str]] = []
    questions: list[str] = []
    for number, run in enumerate(file.runs):
        where = f"runs[{number}]"
        sweeps = files.read(where, path, file, run)
        data = files.folder / run.file
        chosen, notes = _chosen(data, run, sweeps)
        assumptions += [(run.name, note) for note in notes]
        for sweep in chosen:
            repeat = run.repeat if sweep.repeat is None else sweep.repeat
            if repeat is None:
                if times[run.name] > 1:
                    raise MeasurementError(
                        f'{path}: {where}: several runs have name = "{run.name}" and no repeat; number their '
                        f"assemblies, such as repeat = 1"
                    )
                repeat = 1
                note = f"{data}: run '{run.name}': its repeat (assembly) is not stated; taken as number 1"
                assumptions.append((run.name, note))
            if given := phases_not_used(file, run):
                assumptions.append((run.name, f"{data}: run '{run.name}': {given}"))
            wanted = {name: file.channels[name] for name in (file.force_channel, *(run.channels or file.channels))}
            sweep = with_stated_ratios(f"{data}: run '{run.name}'", sweep, wanted)
            _check_phases(f"{data}: run '{run.name}'", file, run, sweep)
            free = [n for n in run.channels or file.channels if n not in (file.force_channel, run.held_channel)]
            sweep, cut = without_overload(f"{data}: run '{run.name}'", sweep, {n: file.label(n) for n in free})
            questions += cut
            measured, notes = measured_run(data, file, run, sweep, repeat)
            runs.append(measured)
            assumptions += [(run.name, note) for note in (*sweep.notes, *notes)]
            if sweep.others:
                note = f"{data}: channels {', '.join(sweep.others)} are not in measurement.toml and not used"
                assumptions.append((run.name, note))
    return tuple(runs), _merged(assumptions), questions


def _check_phases(where: str, file: MeasurementFile, run: RunTable, sweep: RecordedSweep) -> None:
    """Of all responses but those stated to have none. One that others' phases are told against has none of its own:
    that which was held, or one of several. A channel that the sweep lacks is refused later, with its label.

    raises: MeasurementError
    """
    names = [
        n for n in run.channels or tuple(file.channels) if n != file.force_channel and file.channels[n].phase is None
    ]
    found = {n: sweep.channels[file.label(n)] for n in names if file.label(n) in sweep.channels}
    force = sweep.channels.get(file.label(file.force_channel))
    told_against = force is not None and force.has_phase
    for name, channel in found.items():
        others = any(one.has_phase for n, one in found.items() if n != name)
        if not (channel.has_phase or (told_against and not channel.per_force and (others or name == run.held_channel))):
            raise MeasurementError(
                f"{where} channel '{name}': its {channel.amplitude.shape[1]} values are all real, so the file gives no "
                "phase for it; give complex values, or its phase or imaginary part too (where the format has options "
                'for these), or state phase = "none" for the channel where there is none'
            )


def _own_units(file: MeasurementFile) -> tuple[str, str]:
    """Of responses and force: "m" and "N", and what stands for them where a channel is not calibrated."""
    sensors = [channel for name, channel in file.channels.items() if name != file.force_channel]
    force = file.channels[file.force_channel]
    responses = dict.fromkeys(c.unit if c.uncalibrated else "m" for c in sensors)
    return " or ".join(responses), force.unit if force.uncalibrated else "N"


def _merged(assumptions: Sequence[tuple[str, str]]) -> list[str]:
    """Sentences on a run each; those that differ by the name of the run alone become one."""
    runs: dict[str, dict[str, None]] = {}
    for run, sentence in assumptions:
        runs.setdefault(sentence.replace(f"run '{run}'", "{run}"), {})[run] = None
    return [s.replace("{run}", f"run '{', '.join(names)}'") for s, names in runs.items()]


def _chosen(data: Path, run: RunTable, sweeps: Sequence[RecordedSweep]) -> tuple[list[RecordedSweep], list[str]]:
    """Those of a file that are the run (what the file leaves open agrees with everything), and what that assumes."""
    wanted = run.run or run.name
    notes: list[str] = []
    if run.run is None and len(sweeps) == 1 and sweeps[0].run != wanted:
        found, label = list(sweeps), sweeps[0].run
        notes = [f"{data}: its only run, '{label}', is taken for '{wanted}'"] if label else []
    else:
        found = [sweep for sweep in sweeps if sweep.run in ("", wanted)]
    if not found:
        labels = list(dict.fromkeys(sweep.run for sweep in sweeps))
        raise MeasurementError(f"{data}: no run '{wanted}' in it; {near(wanted, labels)} (state it as run = \"...\")")
    matching = [
        sweep
        for sweep in found
        if (run.sweep is None or sweep.sweep in ("", run.sweep))
        and (run.repeat is None or sweep.repeat in (None, run.repeat))
    ]
    there = ", ".join(f"repeat {sweep.repeat or 'not stated'} {sweep.sweep}".strip() for sweep in found)
    if not matching:
        raise MeasurementError(f"{data}: run '{wanted}' has no sweep {run.sweep}, repeat {run.repeat}; it has {there}")
    if len({sweep.sweep for sweep in matching}) > 1:
        raise MeasurementError(
            f"{data}: run '{wanted}' has sweeps up and down ({there}); list two runs of different names, each with "
            f'sweep and run = "{wanted}"'
        )
    if len({sweep.repeat for sweep in matching}) < len(matching):
        raise MeasurementError(
            f"{data}: run '{wanted}' has more than one sweep of the same repeat ({there}); label the runs or repeats "
            f"in the file, or put each into its own"
        )
    return matching, notes


def _stated_only(path: Path, table: dict[str, object], files: _Files) -> Measurement:
    file = read_features(path, table)
    assumptions = [
        f"{path.name}: {key} is not stated; the rig file's is taken"
        for key in ("damper_load", "excitation")
        if getattr(file, key) is None
    ]
    return Measurement(
        title=file.source.title,
        pull=math.nan if file.damper_load is None else file.damper_load,
        excitation=file.excitation or "",
        channels=(),
        runs=(),
        features=file.features(),
        assumptions=tuple(assumptions),
        hashes=files.hashes,
    )


def _features(file: MeasurementFile, files: _Files) -> tuple[Feature, ...]:
    if file.features is None:
        return ()
    path = files.folder / file.features
    usable_file(path)
    files.hash(path)
    return read_features(path, read_measurement_table(path)).features()


def _check_points(path: Path, named: dict[str, str], points: Sequence[str] | None) -> None:
    if points is None:
        return
    lines = [
        f'{key} = "{point}": the model has no such point; {near(point, points)}'
        for key, point in named.items()
        if point not in points
    ]
    if lines:
        raise MeasurementError("\n".join([f"{path}:", *lines]))


def _conventions(file: MeasurementFile) -> list[str]:
    found = []
    if all(channel.amplitude is None for channel in file.channels.values()):
        found.append("amplitude is not stated for any channel; all are read as peak values")
    if file.time_convention is None:
        found.append("time_convention is not stated; phases are read as exp(+iwt), a lag is negative")
    return found


def _few_repeats(runs: Sequence[MeasuredRun]) -> list[str]:
    assemblies: dict[str, set[int]] = {}
    for run in runs:
        assemblies.setdefault(run.name, set()).add(run.repeat)
    few = [f"'{name}' ({len(numbers)})" for name, numbers in assemblies.items() if len(numbers) < FEW_REPEATS]
    if not few:
        return []
    return [
        f"fewer than {FEW_REPEATS} assemblies were measured of {', '.join(few)}: the scatter from one assembly to the "
        f"next is hardly known from them"
    ]
