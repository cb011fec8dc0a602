"""measurement.toml: what a test engineer writes beside the data files, checked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, Field, ValidationError, model_validator

from updamp.measurement.cross_checks import problems_of
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.tables import ChannelTable, RunTable, Text, force_channel_of
from updamp.rig.errors import explain
from updamp.rig.fields import InputTable, Quantity
from updamp.rig.toml_file import read_toml

Model = TypeVar("Model", bound=BaseModel)


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
    level_error: that of the amplitudes of a whole run, from run to run of one assembly: of the force's control and
    gauge, of a laser that is aligned anew
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
    level_error: Annotated[float, Field(strict=True, gt=0, lt=1, examples=[0.001])] | None = None
    channels: Annotated[Mapping[str, ChannelTable], Field(min_length=1)]
    runs: Annotated[
        tuple[RunTable, ...], BeforeValidator(_listed_once), Field(examples=[[{"name": "OOP 17 N", "mode": "OOP"}]])
    ]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if problems := problems_of(self.channels, self.runs, self.excitation):
            raise ValueError("\n".join(problems))
        return self

    @property
    def force_channel(self) -> str:
        return force_channel_of(self.channels)

    @property
    def labels(self) -> tuple[str, ...]:
        """Of all channels, the force first."""
        return tuple(self.label(n) for n in sorted(self.channels, key=lambda name: name != self.force_channel))

    def label(self, channel: str) -> str:
        """How the data files call the channel."""
        return self.channels[channel].label or channel


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
