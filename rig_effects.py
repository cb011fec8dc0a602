"""What a rig file has taken up beside the rig: physical effects, `[[effects]]`, and a calibration, `[calibration]`.

Which effects and factors there are is known to the diagnosis. It is asked when a file states any, so that the input
model depends on none of it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo

from updamp.rig_fields import Section


class TakenEffect(Section):
    """An effect of the file, checked. Names and numbers alone: processes hand it on, and hashes are made of it.

    values: of all its parameters, in their `units`; origin: where they come from, "" if not stated
    file: of a user's own effect, else None; code: SHA-256 of what defines it, "" for one of updamp's own
    What does not change the model is left out of its serialised form, and so out of hashes.
    """

    name: str
    values: Mapping[str, float]
    code: str = ""
    units: Annotated[Mapping[str, str], Field(exclude=True)]
    origin: Annotated[str, Field(exclude=True)] = ""
    file: Annotated[Path | None, Field(exclude=True)] = None


class Calibration(Section):
    """Factors on what is known only roughly, by name (see `diagnosis/model/parameters.py`); origin: in words."""

    factors: Mapping[str, float] = {}
    origin: Annotated[str, Field(exclude=True)] = ""

    def __bool__(self) -> bool:
        return bool(self.factors)


def _effects(tables: Any, info: ValidationInfo) -> Any:
    from updamp.diagnosis.effects.chosen import taken_effects

    return taken_effects(tables, Path((info.context or {}).get("folder", ".")))


def _calibration(table: Any) -> Any:
    from updamp.diagnosis.model.calibration import read_calibration

    return read_calibration(table)


# raise: RigError whose lines name their keys
Effects = Annotated[tuple[TakenEffect, ...], BeforeValidator(_effects)]
CalibrationTable = Annotated[Calibration, BeforeValidator(_calibration)]
