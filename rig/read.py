"""From a rig file to a `Rig`: read, checked, every problem in one message."""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from updamp.rig.checks import buildable
from updamp.rig.effects import Readers
from updamp.rig.errors import RigError, explain
from updamp.rig.fields import InputTable
from updamp.rig.rig import Rig
from updamp.rig.toml_file import read_toml

Kind = TypeVar("Kind", bound=InputTable)


def read_rig(path: Path, readers: Readers, overrides: Mapping[str, Any] | None = None) -> Rig:
    """Read and check a rig file.

    path: TOML file; files it names are sought beside it
    overrides: values as in the file that replace the file's own, by dotted path,
        such as {"blade.thickness": "7.4 mm"}
    raises: RigError with every problem found, one a line
    """
    rig = read_section(path, Rig, readers, "a rig file, such as rigs/pesaresi2017.toml", overrides)
    if problems := buildable(rig):
        raise RigError("\n".join([f"{path}:", *problems]))
    return rig


def read_section(
    path: Path, kind: type[Kind], readers: Readers, what: str, overrides: Mapping[str, Any] | None = None
) -> Kind:
    """A whole file as one table. what: is wanted, for the message where there is no such file; raises: RigError"""
    table = read_toml(path, what, kind="rig file")
    for key, value in (overrides or {}).items():
        _override(table, key, value)
    try:
        return kind.model_validate(table, context={"folder": path.parent, "readers": readers})
    except ValidationError as error:
        raise RigError("\n".join([f"{path}:", *explain(error, kind)])) from None


def _override(table: dict[str, Any], key: str, value: Any) -> None:
    *parents, last = key.split(".")
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise RigError(f"{key} = {value!r}: {parent} is not a table, so {last} cannot be set in it")
    table[last] = deepcopy(value)  # a later override may reach into it
