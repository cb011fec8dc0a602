"""`comparison.json`: a `Comparison` as text, every number kept to the last digit."""

from pathlib import Path
from typing import Any

from updamp.diagnosis.comparison import Comparison
from updamp.diagnosis.json_document import JsonDocument

DOCUMENT = JsonDocument(Comparison, "updamp comparison 1", "updamp compare")


def to_json(comparison: Comparison) -> dict[str, Any]:
    """The fields of `Comparison` by their names, and `schema`; complex as {"re", "im"}, nan as null"""
    return DOCUMENT.to_json(comparison)


def from_json(content: dict[str, Any]) -> Comparison:
    """raises: ValueError naming what is missing, unknown or of the wrong kind"""
    return DOCUMENT.from_json(content)


def write_json(path: Path, comparison: Comparison) -> None:
    DOCUMENT.write(path, comparison)


def read_json(path: Path) -> Comparison:
    """raises: ValueError naming the file and what is wrong with it"""
    return DOCUMENT.read(path)
