"""The row of units that programs write below the names of columns, and what it says against what is stated."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import quantity_of_label, spellings
from updamp.measurement.readers.csv_form import looks_like_number
from updamp.rig.fields import Quantity

HERTZ, SECONDS, ANGLE = ("Hz", "rad/s"), ("s",), ("rad",)  # kinds of units that an axis may have
_IN_BRACKETS = re.compile(r"\S\s*[\[(<]([^\[\]()<>]+)[\])>]\s*$")
_BRACKETS = {"[": "]", "(": ")", "<": ">"}
# To pint "Grad" is a billion rad, "grad" 0.9 degrees, and the others are nothing.
_WORDS = {"Grad": "deg", "grad": "deg", "Sek": "s", "Sek.": "s", "U/min": "rpm"}


def is_row_of_units(cells: Sequence[str]) -> bool:
    """Of the columns that hold numbers: whether none of them is one here, though they are not empty."""
    filled = [cell for cell in cells if cell.strip()]
    return bool(filled) and not any(looks_like_number(cell) for cell in filled)


def plain_unit(text: str) -> str:
    """Without the brackets around all of it: "[mm/s]", "(mm/s)"; those of "(m/s)/N" stay."""
    text = text.strip()
    while text and _BRACKETS.get(text[0]) == text[-1] and not _closes_before_its_end(text):
        text = text[1:-1].strip()
    return text


def _closes_before_its_end(text: str) -> bool:
    opening, closing, depth = text[0], _BRACKETS[text[0]], 0
    for sign in text[:-1]:
        depth += (sign == opening) - (sign == closing)
        if depth == 0:
            return True
    return False


def units_of_names(names: Iterable[str]) -> dict[str, str]:
    """Of columns whose names end with one in brackets, such as "tip [mm]" or "f (rad/s)"; other words are no units."""
    bracketed = {name: found.group(1).strip() for name in names if (found := _IN_BRACKETS.search(name))}
    return {name: unit for name, unit in bracketed.items() if _is_unit(unit)}


def _is_unit(text: str) -> bool:
    axes = (*HERTZ, *SECONDS, *ANGLE)
    return bool(quantity_of_label(text)) or any(_in(kind, one) is not None for kind in axes for one in spellings(text))


def _in(kind: str, unit: str) -> float | None:
    """One of a unit in that of a kind; None where it is no such unit"""
    try:
        return Quantity(kind, f"1 {kind}").to_si(f"1 {unit}")
    except ValueError:
        return None


def check_axis(path: Path, units: Mapping[str, str], column: str, wanted: str, kinds: Sequence[str]) -> None:
    """Of a column that is read in one unit alone. units: of the row, by column; kinds: HERTZ, SECONDS or ANGLE

    raises: MeasurementError where the row of units has another one, which is understood
    """
    text = units.get(column, "")
    expected = Quantity(kinds[0], f"1 {kinds[0]}").to_si(f"1 {wanted}")
    for spelled in spellings(_WORDS.get(text, text)) if text else ():
        for kind in kinds:
            if (factor := _in(kind, spelled)) is None:
                continue
            if kind == kinds[0] and math.isclose(factor, expected, rel_tol=1e-6):
                return
            says, of = ("name", "that name") if text in column else ("row of units", "that row")
            raise MeasurementError(
                f"{path}: column '{column}': its {says} says {text}, it is read in {wanted}; convert the column, "
                f"or correct {of} (a line that begins with # is not read)"
            )
