"""How a CSV file is written: what parts its columns, and what its numbers look like."""

import re
from typing import Literal

from updamp.rig.fields import InputTable

OTHER_DELIMITERS = {";": "semicolon", ",": "comma", "\t": "tab"}
_COMMAS = str.maketrans({",": ".", ".": " . "})  # a point beside decimal commas parts thousands: no number here
_SIGNS_OF_NUMBERS = re.compile(r"[-+\d.,'\seE]+")


class CsvForm(InputTable):
    """How a CSV file is written. delimiter: between its columns; decimal: "," where its numbers have decimal commas"""

    delimiter: Literal[",", ";", "\t"] = ","
    decimal: Literal[".", ","] = "."

    def plain(self, text: str) -> str:
        """The text of a number with a decimal point."""
        return text if self.decimal == "." else with_point(text)


PLAIN = CsvForm()


def with_point(text: str) -> str:
    """The text of a number with a decimal comma, with a point."""
    return text.translate(_COMMAS)


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text


def looks_like_number(text: str) -> bool:
    """Whether it is meant as one, whatever its decimal sign and what parts its thousands."""
    only_digits = _SIGNS_OF_NUMBERS.fullmatch(text) is not None and any(sign.isdigit() for sign in text)
    return only_digits or is_number(text)
