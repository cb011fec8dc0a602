"""Stated values and bounds instead of curves, as a paper or a report gives them."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, model_validator

from updamp.measurement.measurement import Feature
from updamp.measurement.measurement_file import validated
from updamp.measurement.tables import Text
from updamp.rig.fields import InputTable, Quantity

# What can be stated, and as what: with a unit, or as a plain number where there is none.
FEATURE_QUANTITIES: Mapping[str, Quantity | None] = {
    "resonance_frequency": Quantity("Hz", "430 Hz", above=0),
    "resonance_frequency_shift": None,
}
_FORCE = Quantity("N", "17 N", above=0)


def _known(name: str) -> str:
    if name not in FEATURE_QUANTITIES:
        raise ValueError(f"unknown; allowed are {', '.join(FEATURE_QUANTITIES)}")
    return name


class FeatureTable(InputTable):
    """One value, or bounds, of a mode at a force (or at none, where it does not matter)."""

    quantity: Annotated[str, AfterValidator(_known), Field(examples=["resonance_frequency"])]
    mode: Annotated[Text, Field(examples=["OOP"])]
    force: str | float | None = None
    value: str | float | None = None
    lower_bound: str | float | None = None
    upper_bound: str | float | None = None
    relative_uncertainty: Annotated[float, Field(gt=0, lt=1, examples=[0.001])] | None = None

    @model_validator(mode="after")
    def _states_something(self) -> Self:
        problems = []
        for key in ("force", "value", "lower_bound", "upper_bound"):
            try:
                self._in_si(key)
            except ValueError as error:
                problems.append(f'{key} = "{getattr(self, key)}": {error}')
        if self.value is None and self.lower_bound is None and self.upper_bound is None:
            problems.append("value: missing; state value, lower_bound or upper_bound")
        if self.value is not None and self.relative_uncertainty is None:
            problems.append("relative_uncertainty: missing; say how exactly the value is stated, such as 0.001")
        if not problems and self._in_si("lower_bound") >= self._in_si("upper_bound"):
            problems.append(f'lower_bound = "{self.lower_bound}": must be below upper_bound = "{self.upper_bound}"')
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _in_si(self, key: str) -> float:
        """nan where not stated"""
        stated = getattr(self, key)
        if stated is None:
            return math.nan
        kind = _FORCE if key == "force" else FEATURE_QUANTITIES[self.quantity]
        if kind is not None:
            return kind.to_si(stated)
        if not isinstance(stated, float):
            raise ValueError("a plain number is wanted, such as 0.01")
        return stated

    def feature(self) -> Feature:
        """In SI."""
        uncertainty = math.nan if self.relative_uncertainty is None else self.relative_uncertainty
        value, lower, upper = (self._in_si(key) for key in ("value", "lower_bound", "upper_bound"))
        return Feature(self.quantity, self.mode, self._in_si("force"), value, lower, upper, uncertainty)


class Source(InputTable):
    """Where the values are from."""

    title: Annotated[Text, Field(examples=["Author, journal, year"])]


class FeatureFile(InputTable):
    """rig, damper_load, excitation: as in measurement.toml, where they are stated."""

    source: Source
    rig: Annotated[Text, Field(examples=["pesaresi2017"])] | None = None
    damper_load: Annotated[float, Quantity("N", "960 N", at_least=0, at_most=1e9)] | None = None
    excitation: Annotated[Text, Field(examples=["blade_right.excitation.x"])] | None = None
    feature: Annotated[tuple[FeatureTable, ...], Field(min_length=1)]

    def features(self) -> tuple[Feature, ...]:
        return tuple(table.feature() for table in self.feature)


def is_feature_file(table: Mapping[str, Any]) -> bool:
    """Whether a TOML file states features and no runs."""
    return "feature" in table and "runs" not in table


def read_features(path: Path, table: Mapping[str, Any]) -> FeatureFile:
    """raises: MeasurementError with every problem found, one a line"""
    return validated(path, table, FeatureFile)
