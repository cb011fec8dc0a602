"""measurement.toml: what a test engineer writes beside the data files, checked; quantities become SI here."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Field,
    StringConstraints,
    ValidationError,
    model_validator,
)

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.quantities import AMPLITUDES, QUANTITIES, si_factor
from updamp.rig.errors import explain
from updamp.rig.fields import InputTable, Quantity
from updamp.rig.toml_file import read_toml

Text = Annotated[str, StringConstraints(min_length=1)]
Model = TypeVar("Model", bound=BaseModel)


def _known_quantity(name: str) -> str:
    if name not in QUANTITIES:
        raise ValueError(f"unknown; allowed are {', '.join(QUANTITIES)}")
    return name


def _known_amplitude(name: str) -> str:
    if name not in AMPLITUDES:
        raise ValueError(f"unknown; allowed are {', '.join(AMPLITUDES)}")
    return name


QuantityName = Annotated[str, AfterValidator(_known_quantity), Field(examples=["velocity"])]


class ChannelTable(InputTable):
    """A sensor. point and direction: what it looks at in the model; a minus: its reading is positive towards minus.

    label: how the data files call it, where that is not the name of the table
    amplitude: "peak", "rms" or "peak_to_peak"
    phase_of: quantity whose phase the file states, where it is not the one of the amplitude
    noise: standard deviation of the real or imaginary part of the reading, in the unit and the sort of its amplitude
    phase: "none" where amplitudes alone were recorded
    recorded: false for a force that was not: it is taken to be the run's level, at every frequency
    uncalibrated: the reading is proportional to the quantity, in a unit that may be any (a strain gauge in "V"); one of
        it stands for one of the quantity's SI unit, in the rig file's modal masses too
    """

    quantity: QuantityName
    point: Annotated[Text, Field(examples=["blade_right.tip"])]
    direction: Annotated[Literal["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"], Field(examples=["-x"])]
    unit: Annotated[str, Field(examples=["mm/s"])]
    label: Annotated[Text, Field(examples=["laser 1"])] | None = None
    amplitude: Annotated[str, AfterValidator(_known_amplitude), Field(examples=["rms"])] | None = None
    phase_of: QuantityName | None = None
    noise: Annotated[str, Field(examples=["0.2 um/s"])] | None = None
    phase: Literal["none"] | None = None
    recorded: Annotated[bool, Field(strict=True, examples=[False])] = True
    uncalibrated: Annotated[bool, Field(strict=True, examples=[True])] = False

    @model_validator(mode="before")
    @classmethod
    def _unit_of_its_quantity(cls, table: Any) -> Any:
        """Where it is missing, with an example that suits the quantity."""
        kind = QUANTITIES.get(str(table.get("quantity"))) if isinstance(table, dict) else None
        if kind is not None and "unit" not in table:
            raise ValueError(f'unit: missing; add it, such as unit = "{kind.example.split(maxsplit=1)[1]}"')
        return table

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _ = self.si_factor
        if self.noise is not None:
            try:
                self.to_si(self.noise)
            except ValueError as error:
                raise ValueError(f'noise = "{self.noise}": {error}') from None
        if self.phase_of is not None and "force" in (self.quantity, self.phase_of) and self.quantity != self.phase_of:
            raise ValueError(f'phase_of = "{self.phase_of}": a force has the phase of a force only; leave the key out')
        if not self.recorded and self.quantity != "force":
            raise ValueError("recorded = false: holds for the force alone, which is then the run's level")
        return self

    @property
    def si_factor(self) -> float:
        """One of its unit in SI. raises: ValueError for a unit that does not measure the quantity"""
        return si_factor(self.unit, self.quantity, self.uncalibrated)

    def to_si(self, text: str) -> float:
        """A number with a unit, in SI. raises: ValueError saying what would be allowed"""
        kind = QUANTITIES[self.quantity]
        if not self.uncalibrated:
            return Quantity(kind.si, kind.example, above=0).to_si(text)
        number, _, unit = text.strip().partition(" ")
        if unit.strip() != self.unit:
            raise ValueError(f'the channel is uncalibrated: state it in its own unit, such as "1.5 {self.unit}"')
        return Quantity("N", "1.5 N", above=0).to_si(f"{number} N")

    @property
    def negative(self) -> bool:
        return self.direction.startswith("-")

    @property
    def model_point(self) -> str:
        """As the model calls it, such as "blade_right.tip.x"."""
        return f"{self.point}.{self.direction[-1]}"


class RunTable(InputTable):
    """One sweep, or all its repeats where one file holds them. Level: peak amplitude of what was held, with its unit.

    run: label of the run in the file, where that is not the name; repeat: number of the assembly
    taken: number of the run in the order in which those of an assembly were made
    channels: those that this run has, where it lacks some; held_channel: whose amplitude was held, for "response"
    """

    name: Annotated[Text, Field(examples=["OOP 17 N"])]
    mode: Annotated[Text, Field(examples=["OOP"])]
    file: Annotated[Text, Field(examples=["oop_17N.csv"])]
    held: Annotated[Literal["force", "response", "nothing"], Field(examples=["force"])]
    level: Annotated[str, Field(examples=["17 N"])] | None = None
    held_channel: Annotated[Text, Field(examples=["tip_right"])] | None = None
    sweep: Literal["up", "down"] | None = None
    repeat: Annotated[int, Field(strict=True, ge=0, examples=[1])] | None = None
    taken: Annotated[int, Field(strict=True, ge=1, examples=[1])] | None = None
    run: Annotated[Text, Field(examples=["OOP 17 N"])] | None = None
    reader: Annotated[Text, Field(examples=["uff"])] | None = None
    channels: Annotated[tuple[Text, ...], Field(min_length=1, examples=[["tip_right"]])] | None = None
    options: Mapping[str, Any] = {}

    @model_validator(mode="after")
    def _level_of_what_was_held(self) -> Self:
        if self.level is None and self.held != "nothing":
            raise ValueError(f'level: missing; held = "{self.held}" needs it, such as level = "17 N"')
        if (self.held == "response") != (self.held_channel is not None):
            raise ValueError('held_channel: is stated where held = "response", such as held_channel = "tip_right"')
        return self


def _listed_once(value: object) -> object:
    if isinstance(value, list) and not value:
        raise ValueError("state at least one run: [[runs]] with name, mode, file, held, level")
    return value


class MeasurementFile(InputTable):
    """All of measurement.toml. rig: name of the rig as in its file; features: file of stated values beside this one

    damper_load: pull of the damper; left out for a rig without one, or where it is the rig file's
    repeatability: relative standard deviation of a response when the test is repeated, known from elsewhere; only where
    no repeats are among the runs
    frequency_drift: relative standard deviation of the resonance from run to run of one assembly (temperature, clock)
    frequency_error: relative standard deviation of a single frequency where a generator's clock is not all: of points
    read off a figure, of a sweep in steps where it jumps
    gain_error: that of a sensor's gain, as on its data sheet
    """

    title: Annotated[Text, Field(examples=["Double-beam rig, damper 3, May 2024"])]
    rig: Annotated[Text, Field(examples=["pesaresi2017"])]
    damper_load: Annotated[float, Quantity("N", "960 N", at_least=0, at_most=1e9)] | None = None
    excitation: Annotated[Text, Field(examples=["blade_right.excitation.x"])]
    time_convention: Annotated[Literal["exp(+iwt)", "exp(-iwt)"], Field(examples=["exp(+iwt)"])] | None = None
    features: Annotated[Text, Field(examples=["stated.toml"])] | None = None
    repeatability: Annotated[float, Field(strict=True, gt=0, lt=1, examples=[0.05])] | None = None
    frequency_drift: Annotated[float, Field(strict=True, gt=0, lt=0.1, examples=[1e-4])] | None = None
    frequency_error: Annotated[float, Field(strict=True, gt=0, lt=0.1, examples=[3.6e-4])] | None = None
    gain_error: Annotated[float, Field(strict=True, gt=0, lt=1, examples=[0.01])] | None = None
    channels: Annotated[Mapping[str, ChannelTable], Field(min_length=1)]
    runs: Annotated[
        tuple[RunTable, ...], BeforeValidator(_listed_once), Field(examples=[[{"name": "OOP 17 N", "mode": "OOP"}]])
    ]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        problems = [*_force_problems(self), *_convention_problems(self)]
        if any(channel.quantity == "force" for channel in self.channels.values()):  # whose level the runs state
            problems += [*_run_problems(self), *_order_problems(self)]
        if problems:
            raise ValueError("\n".join(problems))
        return self

    @property
    def force_channel(self) -> str:
        return next(name for name, channel in self.channels.items() if channel.quantity == "force")

    @property
    def labels(self) -> tuple[str, ...]:
        """Of all channels, the force first."""
        return tuple(self.label(n) for n in sorted(self.channels, key=lambda name: name != self.force_channel))

    def label(self, channel: str) -> str:
        """How the data files call the channel."""
        return self.channels[channel].label or channel


def _force_problems(file: MeasurementFile) -> list[str]:
    forces = [name for name, channel in file.channels.items() if channel.quantity == "force"]
    if not forces:
        return [
            'channels: none has quantity = "force"; responses are held against it: add a table [channels.force] with '
            'quantity = "force", point, direction and unit (and recorded = false where its level alone is known)'
        ]
    if len(forces) > 1:
        return [f"channels: {', '.join(forces)} are all forces; keep the one at the excitation"]
    if len(file.channels) == 1:
        return ["channels: there is a force only; add the response's"]
    point = file.channels[forces[0]].model_point
    if point != file.excitation:
        return [
            f'channels.{forces[0]}.point: the force is at "{point}", excitation = "{file.excitation}"; make them one'
        ]
    return []


def _convention_problems(file: MeasurementFile) -> list[str]:
    """Where some state what others leave open, nobody knows whether the others were forgotten."""
    lines = []
    for key in ("amplitude", "noise"):
        named = {name: getattr(channel, key) for name, channel in file.channels.items()}
        for name, channel in file.channels.items():
            if channel.quantity == "force" and (key == "noise" or not channel.recorded):  # then it is the run's level
                named.pop(name)
        open_ones = [name for name, value in named.items() if value is None]
        if open_ones and len(open_ones) < len(named):
            lines.append(
                f"channels.{open_ones[0]}.{key}: missing, while other channels state it (mixed conventions); "
                f"state it for all of them or for none"
            )
    labels = [file.label(name) for name in file.channels]
    for label in sorted({label for label in labels if labels.count(label) > 1}):
        lines.append(f'channels: more than one has label = "{label}"; every channel needs its own')
    return lines


def _order_problems(file: MeasurementFile) -> list[str]:
    """Of all runs or of none, and each of an assembly at its own place."""
    if all(run.taken is None for run in file.runs):
        return []
    lines = []
    for i, run in enumerate(file.runs):
        if run.taken is None:
            lines.append(f"runs[{i}].taken: missing, and others have it; number all runs as they were made, or none")
            continue
        for j, other in enumerate(file.runs[:i]):
            if run.taken == other.taken and (run.repeat == other.repeat or None in (run.repeat, other.repeat)):
                lines.append(f"runs[{i}].taken = {run.taken}: so has runs[{j}] of the same assembly; number them anew")
    return lines


def _run_problems(file: MeasurementFile) -> list[str]:
    lines = []
    first: dict[str, RunTable] = {}
    listed: set[str] = set()
    for i, run in enumerate(file.runs):
        here = f"runs[{i}]"
        for key, names in (("channels", run.channels or ()), ("held_channel", (run.held_channel,))):
            for name in names:
                if name is not None and name not in file.channels:
                    lines.append(f'{here}.{key} = "{name}": no such channel; {near(name, file.channels)}')
        if not file.channels[file.force_channel].recorded and (run.held != "force" or run.level is None):
            lines.append(f'{here}.held: the force was not recorded, so it is the level: held = "force" and level')
        if not any(line.startswith(f"{here}.held") for line in lines):
            lines += _level_problems(file, run, here)
        other = first.setdefault(run.name, run)
        for key in ("mode", "held", "level", "sweep", "held_channel"):
            if getattr(other, key) != getattr(run, key):
                lines.append(
                    f'{here}.{key} = "{getattr(run, key)}": another run of the name "{run.name}" has '
                    f'"{getattr(other, key)}"; runs of one name are repeats of one test, give the others another name'
                )
        same = run.model_dump_json()
        if same in listed:
            lines.append(f'{here}.name = "{run.name}": the very same run is listed twice; take one of them out')
        listed.add(same)
    return lines


def _level_problems(file: MeasurementFile, run: RunTable, here: str) -> list[str]:
    try:
        level_in_si(file, run)
    except ValueError as error:
        return [f'{here}.level = "{run.level}": {error}']
    return []


def level_in_si(file: MeasurementFile, run: RunTable) -> float | None:
    """[N], or SI of the channel held; None where nothing is stated. raises: ValueError where unit or number is wrong"""
    if run.level is None:
        return None
    return file.channels[run.held_channel or file.force_channel].to_si(run.level)


def read_measurement_table(path: Path) -> dict[str, Any]:
    """A TOML file as it is. raises: MeasurementError where it cannot be read"""
    return read_toml(path, "a measurement.toml (docs/measurements.md)", MeasurementError, "measurement")


def validated(path: Path, table: Mapping[str, Any], model: type[Model], where: str = "") -> Model:
    """raises: MeasurementError with every problem found, one a line: key = value, what is wrong, what is allowed"""
    try:
        return model.model_validate(table)
    except ValidationError as error:
        lines = [f"{where}{line}" for line in explain(error, model)]
        raise MeasurementError("\n".join([f"{path}:", *lines])) from None


def with_defaults(path: Path, table: Mapping[str, Any]) -> dict[str, Any]:
    """The table with `[run_defaults]` written out into every run that does not say otherwise."""
    table = dict(table)
    defaults = table.pop("run_defaults", {})
    runs = table.get("runs")
    if not isinstance(defaults, dict) or not isinstance(defaults.get("options", {}), dict):
        raise MeasurementError(f"{path}: run_defaults: a table of keys is wanted, [run_defaults]")
    if isinstance(runs, list) and all(isinstance(run, dict) for run in runs):
        table["runs"] = [_merged(defaults, run) for run in runs]
    return table


def _merged(defaults: Mapping[str, Any], run: Mapping[str, Any]) -> dict[str, Any]:
    merged = {**defaults, **run}
    ours, theirs = defaults.get("options", {}), run.get("options", {})
    if "options" in merged and isinstance(ours, dict) and isinstance(theirs, dict):
        merged["options"] = {**ours, **theirs}
    return merged
