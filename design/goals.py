"""What a study wants of its responses: objectives to be made small, limits to be kept."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Protocol

from pydantic import Field

from updamp.rig.fields import InputTable, Quantity

Stated = Annotated[float, Field(strict=True)] | str


class Goal(Protocol):
    """What is wanted of one response; values in the response's unit."""

    def loss(self, value: float) -> float:
        """Smaller is better."""
        ...

    @property
    def words(self) -> str: ...


@dataclass(frozen=True)
class Minimise:
    words: str = "minimise"

    def loss(self, value: float) -> float:
        return value


@dataclass(frozen=True)
class Maximise:
    words: str = "maximise"

    def loss(self, value: float) -> float:
        return -value


@dataclass(frozen=True)
class Target:
    """tolerance: what counts as one unit of misfit, such as the uncertainty of a measured value"""

    target: float
    tolerance: float

    def residual(self, value: float) -> float:
        return (value - self.target) / self.tolerance

    def loss(self, value: float) -> float:
        return abs(self.residual(value))

    @property
    def words(self) -> str:
        return f"target {self.target:g} +- {self.tolerance:g}"


class ObjectiveTable(InputTable):
    """One [[objectives]]. goal: minimise, maximise or target; target, tolerance: for goal = "target" """

    response: str
    goal: str = "minimise"
    target: Stated | None = None
    tolerance: Stated | None = None


@dataclass(frozen=True)
class Objective:
    response: str
    goal: Goal


def _without_target(goal: Goal) -> Callable[[ObjectiveTable, str], Goal]:
    def make(table: ObjectiveTable, _: str) -> Goal:
        if table.target is not None or table.tolerance is not None:
            raise ValueError(f'target, tolerance: belong to goal = "target"; take them out of goal = "{table.goal}"')
        return goal

    return make


def _target(table: ObjectiveTable, unit: str) -> Goal:
    stated = {"target": table.target, "tolerance": table.tolerance}
    numbers = {}
    for key, value in stated.items():
        if value is None:
            raise ValueError(f'{key}: missing; goal = "target" needs target and tolerance')
        try:
            numbers[key] = in_unit_of(unit, value)
        except ValueError as error:
            raise ValueError(f"{key} = {value!r}: {error}") from None
    if numbers["tolerance"] <= 0:
        raise ValueError(f"tolerance = {table.tolerance!r}: must be above 0")
    return Target(**numbers)


GOALS: Mapping[str, Callable[[ObjectiveTable, str], Goal]] = {
    "minimise": _without_target(Minimise()),
    "minimize": _without_target(Minimise()),
    "maximise": _without_target(Maximise()),
    "maximize": _without_target(Maximise()),
    "target": _target,
}


def objective(table: ObjectiveTable, units: Mapping[str, str]) -> Objective:
    """units: response -> its unit. raises: ValueError, its sentence begins with the key of the table"""
    _known_response(table.response, units)
    if table.goal not in GOALS:
        raise ValueError(f'goal = "{table.goal}": unknown; allowed are {", ".join(GOALS)}')
    return Objective(table.response, GOALS[table.goal](table, units[table.response]))


class ConstraintTable(InputTable):
    """One [[constraints]]: a lower limit of a response, an upper one, or both."""

    response: str
    lower: Stated | None = None
    upper: Stated | None = None


@dataclass(frozen=True)
class Constraint:
    """lower, upper: in the response's unit, infinite where there is none"""

    response: str
    lower: float
    upper: float

    def violation(self, value: float) -> float:
        """By how much the nearer limit is passed, in the response's unit; 0 or less where both are kept."""
        return max(self.lower - value, value - self.upper)


def constraint(table: ConstraintTable, units: Mapping[str, str]) -> Constraint:
    """raises: ValueError, its sentence begins with the key of the table"""
    _known_response(table.response, units)
    if table.lower is None and table.upper is None:
        raise ValueError("lower, upper: both missing; state one of them at least")
    limits = {"lower": -float("inf"), "upper": float("inf")}
    for key in limits:
        stated = getattr(table, key)
        if stated is None:
            continue
        try:
            limits[key] = in_unit_of(units[table.response], stated)
        except ValueError as error:
            raise ValueError(f"{key} = {stated!r}: {error}") from None
    if not limits["lower"] < limits["upper"]:
        raise ValueError(f"lower = {table.lower}, upper = {table.upper}: the lower limit must be below the upper one")
    return Constraint(table.response, **limits)


def in_unit_of(unit: str, stated: float | str) -> float:
    """A number of a study file in the unit of the response that it limits or aims at.

    raises: ValueError with an example, where the unit is missing, of another kind, or not wanted
    """
    if not unit:
        if isinstance(stated, str):
            raise ValueError("a plain number is wanted, without a unit")
        return float(stated)
    return Quantity(unit, f"1 {unit}").in_unit(stated, unit)


def _known_response(name: str, units: Mapping[str, str]) -> None:
    if name not in units:
        raise ValueError(f'response = "{name}": the study has no such response; it has {", ".join(units)}')
