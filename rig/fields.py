"""What a rig file is made of: tables that refuse unknown keys, and quantities that become SI floats once."""

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import Any

import pint
from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)\b"
_DECIMAL_COMMA = re.compile(r",\d")  # what is left of "150,5 mm" after the number
_NUMBER_AND_UNIT = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*")


LOGARITHMIC = "is logarithmic; give values as they are (an amplitude is 10^(dB/20) of its reference)"


class InputTable(BaseModel):
    """A table of the rig file: frozen, and unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float that is read from text with a unit: Annotated[float, Quantity("m", "150 mm")].

    si: the SI unit of the float
    example: number and unit as a person would write them; error messages show it
    above, at_least, at_most: bounds, in the unit of the example
    """

    si: str
    example: str
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Replace the float's own schema: a bare number is never a quantity."""
        return core_schema.no_info_plain_validator_function(self.to_si)

    @property
    def allowed(self) -> str:
        """The bounds in words, such as "above 0 mm and at most 1000 mm"; empty if there are none."""
        unit = self.example.split(maxsplit=1)[1]
        bounds = [("above", self.above), ("at least", self.at_least), ("at most", self.at_most)]
        return " and ".join(f"{word} {bound:g} {unit}" for word, bound in bounds if bound is not None)

    def to_si(self, text: object) -> float:
        """Text with a unit to a float in SI.

        raises: ValueError, with what would be allowed, if the unit is missing, unknown, logarithmic or of another
            dimension, or the number is not finite or out of range
        """
        if isinstance(text, (int, float)) and not isinstance(text, bool):
            raise ValueError(f'state its unit as text, such as "{self.example}"')
        number, unit = self._split(text)
        if is_logarithmic(written := self.unit_of(text)):
            raise ValueError(f'"{written}" {LOGARITHMIC}, like "{self.example}"')
        # Root units, not dimensions: radians have none, so "2700 rad/s" would pass for hertz, "45 %" for an angle.
        if (1 * unit).to_root_units().units != _registry().Quantity(1, self.si).to_root_units().units:
            raise ValueError(f'wrong dimension: needs a unit of the kind {self.si}, such as "{self.example}"')
        value = _registry().Quantity(number, unit)
        try:
            in_si = float(value.to(self.si).magnitude) if number.is_finite() else math.inf
            in_example = float(value.to(self.example.split(maxsplit=1)[1]).magnitude) if number.is_finite() else in_si
        except ArithmeticError:  # beyond what decimal numbers hold
            in_si = math.inf
        if not math.isfinite(in_si):
            raise ValueError(f'not a finite number; write it like "{self.example}"')
        self._check_range(in_example)
        return in_si

    def in_unit(self, text: object, unit: str) -> float:
        """As `to_si`, in another unit of the same kind; raises: ValueError as `to_si`"""
        self.to_si(text)
        number, stated = self._split(text)
        return float(_registry().Quantity(number, stated).to(unit).magnitude)

    def unit_of(self, text: object) -> str:
        """The unit as it is written; raises: ValueError as `to_si`"""
        return str(self._parts(text)[1])

    def _split(self, text: object) -> tuple[Decimal, pint.Unit]:
        number, unit = self._parts(text)
        try:
            return number, _registry().parse_units(unit)
        except Exception:  # whatever the parser's tokenizer, look-ups or arithmetic stumble over
            raise ValueError(f'unknown unit "{unit}"; write it like "{self.example}"') from None

    def _parts(self, text: object) -> tuple[Decimal, str]:
        match = _NUMBER_AND_UNIT.fullmatch(text) if isinstance(text, str) else None
        if match is None:
            raise ValueError(f'not a number with a unit; write it like "{self.example}"')
        if _DECIMAL_COMMA.match(match[2]):
            raise ValueError(f'numbers have a decimal point: "{str(text).strip().replace(",", ".", 1)}"')
        if not match[2]:
            raise ValueError(f'state its unit, such as "{self.example}"')
        return Decimal(match[1]), match[2]

    def _check_range(self, number: float) -> None:
        if (
            (self.above is not None and not number > self.above)
            or (self.at_least is not None and not number >= self.at_least)
            or (self.at_most is not None and not number <= self.at_most)
        ):
            raise ValueError(f"out of range: allowed is {self.allowed}")


@cache
def _registry() -> pint.UnitRegistry:
    """With decimal numbers, so that "60000 N/mm^3" is 6e13 and not 5.999...e13; and with what vibration engineers in
    the United States write: a mil is a thousandth of an inch (to pint an angle of artillery), ips is inch per second.
    """
    registry: pint.UnitRegistry = pint.UnitRegistry(non_int_type=Decimal, on_redefinition="ignore")
    registry.define("@alias thou = mil")
    registry.define("ips = inch / second")
    return registry


def is_logarithmic(unit: str) -> bool:
    """Whether it stands for a logarithm, as dB, Np and octave do; not where it is no unit at all."""
    try:
        parsed = _registry().parse_units(unit)
    except Exception:  # as in `Quantity._split`
        return False
    try:
        (1 * parsed).to_root_units()
    except Exception:  # decimal numbers have no such logarithm in pint, and dB/s has no root units
        return True
    return False


def damped(loss_factor: float) -> float:
    """That of a structure with contacts. raises: ValueError where it is zero"""
    if loss_factor == 0:
        raise ValueError(
            "as long as no contact slips nothing else takes up work, and without any damping a resonance has no bound; "
            "steel has 0.0001 to 0.01: state what was measured, or 0.0001 for very little"
        )
    return loss_factor
