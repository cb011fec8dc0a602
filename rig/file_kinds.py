"""Which of the project's files a table is: a person who hands over the wrong one is told so, not its unknown keys."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

# kind -> the command that takes it
KINDS: Mapping[str, str] = {
    "rig file": "updamp run, or updamp compare with a measurement",
    "measurement": "updamp compare RIG MEASUREMENT",
    "design study": "updamp design",
    "parameter study": "updamp study",
}


def kind_of(table: Mapping[str, Any]) -> str:
    """By the keys that no other kind has; "" where they do not tell."""
    if "runs" in table or "feature" in table:
        return "measurement"
    if {"variables", "responses", "objectives", "method"} & set(table):
        return "design study"
    if {"variants", "families"} & set(table):
        return "parameter study"
    if {"blade", "platform", "damper", "mesh"} & set(table) or ("modes" in table and "excitation" in table):
        return "rig file"
    return ""


def check_kind(path: Path, table: Mapping[str, Any], wanted: str, failure: type[ValueError]) -> None:
    """raises: `failure` where the table is another kind of file than wanted, naming the command that takes it"""
    found = kind_of(table)
    if found and found != wanted:
        raise failure(f"{path}: this is a {found}, a {wanted} is wanted here; a {found} is for: {KINDS[found]}")
