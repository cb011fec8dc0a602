"""`diagnosis.json`: a `Verdict` as text, every number kept to the last digit."""

from pathlib import Path
from typing import Any

from updamp.diagnosis.json_document import JsonDocument
from updamp.diagnosis.verdict import Verdict

DOCUMENT = JsonDocument(Verdict, "updamp diagnosis 1", "updamp diagnose")


def to_json(verdict: Verdict) -> dict[str, Any]:
    """The fields of `Verdict` by their names, and `schema`; nan as null"""
    return DOCUMENT.to_json(verdict)


def from_json(content: dict[str, Any]) -> Verdict:
    """raises: ValueError naming what is missing, unknown or of the wrong kind"""
    return DOCUMENT.from_json(content)


def write_json(path: Path, verdict: Verdict) -> None:
    DOCUMENT.write(path, verdict)


def read_json(path: Path) -> Verdict:
    """raises: ValueError naming the file and what is wrong with it"""
    return DOCUMENT.read(path)
