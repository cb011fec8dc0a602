"""Variables of a study: numbers of the rig file with bounds, in the unit that the study states them in."""

import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from updamp.design.rig_numbers import AnyRig, RigNumber, number_at
from updamp.rig.fields import InputTable
from updamp.rig.rig import Name

Values = Mapping[str, float]
"""Name of a variable -> its value in the variable's unit."""

Stated = Annotated[float, Field(strict=True)] | str


class VariableTable(InputTable):
    """One [[variables]] of a study file.

    path: of a number of the rig file, such as "damper.face_length"; name: in tables and pictures, the path by default
    lower, upper: bounds, with the unit where the rig file has one
    initial: where a search begins, by default the rig's own value, or the bound that is nearest to it
    scale: "log" for what varies over decades
    """

    path: Annotated[str, Field(examples=["damper.face_length"])]
    name: Name | None = None
    lower: Annotated[Stated, Field(examples=["3 mm"])]
    upper: Annotated[Stated, Field(examples=["6 mm"])]
    initial: Stated | None = None
    scale: Literal["linear", "log"] = "linear"


@dataclass(frozen=True)
class Variable:
    """lower, upper, initial: in `unit`, that of the stated lower bound; "" for a plain number
    logarithmic: whether equal shares of the range are equal ratios; whole: whether values are integers
    """

    name: str
    path: str
    unit: str
    lower: float
    upper: float
    initial: float
    logarithmic: bool = False
    whole: bool = False

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 to 1."""
        share = min(max(float(share), 0.0), 1.0)
        if self.logarithmic:
            value = self.lower * (self.upper / self.lower) ** share
        else:
            value = self.lower + share * (self.upper - self.lower)
        value = min(max(value, self.lower), self.upper)
        return float(round(value)) if self.whole else float(f"{value:.12g}")

    def share(self, value: float) -> float:
        if self.logarithmic:
            return math.log(value / self.lower) / math.log(self.upper / self.lower)
        return (value - self.lower) / (self.upper - self.lower)

    def written(self, value: float) -> str | float | int:
        """As in a rig file."""
        if self.whole:
            return round(value)
        return f"{value!r} {self.unit}" if self.unit else value

    @property
    def label(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def variable(table: VariableTable, rig: AnyRig) -> Variable:
    """raises: ValueError, its sentence begins with the key of the table"""
    try:
        number = number_at(rig, table.path)
    except ValueError as error:
        raise ValueError(f'path = "{table.path}": {error}') from None
    unit = _unit(number, table.lower)
    lower, upper = (_value(number, unit, key, getattr(table, key)) for key in ("lower", "upper"))
    for key, bound in (("lower", lower), ("upper", upper)):
        if number.whole and bound != round(bound):
            raise ValueError(f"{key} = {getattr(table, key)!r}: a whole number is wanted")
    if not lower < upper:
        raise ValueError(f"lower = {table.lower}, upper = {table.upper}: the lower bound must be below the upper one")
    if table.scale == "log" and lower <= 0:
        raise ValueError(f'lower = {table.lower}: must be above 0 with scale = "log"')
    initial = _initial(number, unit) if table.initial is None else _value(number, unit, "initial", table.initial)
    if table.initial is not None and not lower <= initial <= upper:
        raise ValueError(f"initial = {table.initial}: must lie between lower = {table.lower} and upper = {table.upper}")
    inside = min(max(initial, lower), upper)
    return Variable(
        table.name or table.path, table.path, unit, lower, upper, inside, table.scale == "log", number.whole
    )


def _unit(number: RigNumber, stated: Stated) -> str:
    if number.quantity is None:
        return ""
    try:
        return number.quantity.unit_of(stated)
    except ValueError as error:
        raise ValueError(f"lower = {stated!r}: {error}") from None


def _value(number: RigNumber, unit: str, key: str, stated: Stated) -> float:
    """In the unit, once the rig file would take it."""
    try:
        if number.quantity is not None:
            value = number.quantity.in_unit(stated, unit)
        elif isinstance(stated, str):
            raise ValueError("a plain number is wanted, without a unit")
        else:
            value = float(stated)
        number.check(stated if number.quantity is not None else int(value) if number.whole else value)
    except ValueError as error:
        raise ValueError(f"{key} = {stated!r}: {error}") from None
    return value


def _initial(number: RigNumber, unit: str) -> float:
    """What the rig has now, to twelve digits: a detour over SI is not seen."""
    if number.quantity is None:
        return number.value
    return float(f"{number.value / _unit_in_si(number, unit):.12g}")


def _unit_in_si(number: RigNumber, unit: str) -> float:
    assert number.quantity is not None, "a unit belongs to a quantity"
    return type(number.quantity)(number.quantity.si, f"1 {unit}").to_si(f"1 {unit}")


def overrides(stated: Mapping[str, Any], variables: Sequence[Variable], values: Values) -> dict[str, Any]:
    """What replaces values of a rig file, by dotted path, as `load_any` takes it.

    stated: the rig file as read; an effect that it does not have is added, its other parameters absent
    """
    changes: dict[str, Any] = {}
    for one in variables:
        first, *rest = one.path.split(".")
        written = one.written(values[one.name])
        if first == "effects":
            tables = changes.setdefault("effects", deepcopy(list(stated.get("effects", []))))
            _set_parameter(tables, ".".join(rest[:-1]), rest[-1], written)
        else:
            changes[one.path] = written
    return changes


def _set_parameter(tables: list[dict[str, Any]], name: str, parameter: str, written: Any) -> None:
    table = next((entry for entry in tables if entry["name"] == name), None)
    if table is None:
        table = {"name": name, "values": {}}
        tables.append(table)
    table["values"] = {**table.get("values", {}), parameter: written}
