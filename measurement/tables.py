"""The tables of measurement.toml: a channel and a run, each checked by itself; quantities become SI here."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from updamp.measurement.quantities import AMPLITUDES, QUANTITIES, si_factor
from updamp.rig.fields import InputTable, Quantity

Text = Annotated[str, StringConstraints(min_length=1)]


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
    per_force: true where the files hold the response divided by the force of the same sweep, in `unit` over the force's
        unit; false where they do not; left out: as the file says, and not divided where it says nothing
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
    per_force: Annotated[bool, Field(strict=True, examples=[True])] | None = None

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
        if self.per_force and self.quantity == "force":
            raise ValueError(
                "per_force = true: is for responses, which the files divide by this force; take the line out of the "
                "force's channel (where the files do not hold the force itself, recorded = false there)"
            )
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


def force_channel_of(channels: Mapping[str, ChannelTable]) -> str:
    """The first, where there are several. raises: StopIteration where there is none"""
    return next(name for name, channel in channels.items() if channel.quantity == "force")


def level_in_si(channels: Mapping[str, ChannelTable], run: RunTable) -> float | None:
    """[N], or SI of the channel held; None where nothing is stated. raises: ValueError where unit or number is wrong"""
    if run.level is None:
        return None
    return channels[run.held_channel or force_channel_of(channels)].to_si(run.level)
