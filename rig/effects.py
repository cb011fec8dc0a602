"""What a rig file has taken up beside the rig: physical effects, `[[effects]]`, and a calibration, `[calibration]`.

Here they are plain data. Which effects and factors there are is known to the catalogue, so the input model is handed
`Readers` for both tables and depends on neither.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo

from updamp.rig.fields import InputTable


class RigEffect(InputTable):
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


class Calibration(InputTable):
    """Factors on what is known only roughly, by name (see `model/calibration.py`); origin: in words."""

    factors: Mapping[str, float] = {}
    origin: Annotated[str, Field(exclude=True)] = ""

    def __bool__(self) -> bool:
        return bool(self.factors)


@dataclass(frozen=True)
class Readers:
    """How the tables [[effects]] and [calibration] are read; whoever knows the effects hands it to `read_rig`.

    effects: from the tables as they stand and the folder where files that they name are sought
    Both raise RigError with every problem found, one a line, each naming its key.
    """

    effects: Callable[[object, Path], tuple[RigEffect, ...]]
    calibration: Callable[[object], Calibration]


def _effects(tables: Any, info: ValidationInfo) -> Any:
    context = info.context or {}
    return context["readers"].effects(tables, context["folder"]) if "readers" in context else tables


def _calibration(table: Any, info: ValidationInfo) -> Any:
    context = info.context or {}
    return context["readers"].calibration(table) if "readers" in context else table


Effects = Annotated[tuple[RigEffect, ...], BeforeValidator(_effects)]
CalibrationTable = Annotated[Calibration, BeforeValidator(_calibration)]
