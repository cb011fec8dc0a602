"""Turns the validation's findings into sentences a person can act on."""

import json
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from types import UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from updamp.rig.fields import Quantity

# What pydantic says of Python's types, in words of a TOML file; braces: of the finding's context.
_IN_A_FILE = {
    "string_type": "text in quotes is wanted",
    "string_too_short": "must not be empty",
    "tuple_type": "a list in square brackets is wanted",
    "too_short": "entries wanted: at least {min_length}",
    "too_long": "entries wanted: at most {max_length}",
}


class RigError(ValueError):
    """A rig file that cannot be used; the message has one line a problem."""


def explain(error: ValidationError, model: type[BaseModel]) -> Iterator[str]:
    """One line a problem: key (dotted path) = value: what is wrong and what would be allowed."""
    for problem in error.errors(include_url=False):
        if _counts_wrong_entries(problem):
            continue
        path, table, field = _locate(problem["loc"], model)
        match problem["type"]:
            case "value_error":
                yield from _own(path, problem)
            case "extra_forbidden":
                yield f"{path} = {_written(problem['input'])}: unknown key; {_known(str(problem['loc'][-1]), table)}"
            case "missing":
                yield f"{path}: missing; {_how_to_add(path, field)}"
            case "union_tag_not_found":
                yield f'{path}.model: missing; add it, such as model = "uniform"'
            case "union_tag_invalid":
                allowed = problem["ctx"]["expected_tags"].replace("'", '"')
                yield f"{path}.model = {_written(problem['ctx']['tag'])}: unknown; allowed are {allowed}"
            case "model_type" | "dict_type":
                yield f"{path} = {_written(problem['input'])}: a table of keys is wanted, [{path}]"
            case "string_pattern_mismatch":
                yield f"{path} = {_written(problem['input'])}: a name is a letter, then letters, digits, _ or -"
            case _:
                yield f"{path} = {_written(problem['input'])}: {_pydantic(path, problem, field)}"


def _counts_wrong_entries(problem: ErrorDetails) -> bool:
    """Whether a list is called too short that is long enough with its wrong entries, which have lines of their own."""
    stated = problem["input"]
    return (
        problem["type"] == "too_short"
        and isinstance(stated, list | tuple | Mapping)
        and len(stated) >= problem["ctx"]["min_length"]
    )


def _pydantic(path: str, problem: ErrorDetails, field: FieldInfo | None) -> str:
    text = problem["msg"].replace("Input should", "should").replace("'", '"')
    if problem["type"] in _IN_A_FILE:
        text = _IN_A_FILE[problem["type"]].format(**problem.get("ctx", {}))
    if field and _tables_of(field.annotation):
        return f"{text}; {_how_to_add(path, field)}"
    examples = _examples(field.annotation, field) if field else []
    return f"{text}, such as {_written(examples[0])}" if examples else text


def _examples(annotation: Any, *about: object) -> list[Any]:
    """Of a field; where it may be left out they stand with the part of its annotation that is not None."""
    for entry in (*about, *getattr(annotation, "__metadata__", ())):
        if isinstance(entry, FieldInfo) and entry.examples:
            return entry.examples
    parts = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else ()
    return next((found for part in parts if (found := _examples(part))), [])


def _own(path: str, problem: ErrorDetails) -> Iterator[str]:
    """The model's own checks: those of a value get its key, those of a table name the key themselves, from that table
    on; a RigError's lines are whole."""
    lines = str(problem["ctx"]["error"]).splitlines()
    if isinstance(problem["ctx"]["error"], RigError):
        yield from lines
    elif not isinstance(problem["input"], Mapping):
        yield from (f"{path} = {_written(problem['input'])}: {line}" for line in lines)
    else:
        yield from (f"{path}.{line}" if path else line for line in lines)


def _locate(loc: tuple[int | str, ...], model: type[BaseModel]) -> tuple[str, type[BaseModel], FieldInfo | None]:
    """Dotted path of a finding, the table it is in and, if the finding is about a key of that table, its field."""
    path, table = "", model
    kind: Any = model
    field: FieldInfo | None = None
    for part in loc:
        kind = _stated(kind)
        origin, arguments = get_origin(kind), get_args(kind)
        if part == "[key]":
            continue
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            table, field = kind, kind.model_fields.get(str(part))
            path, kind = f"{path}.{part}", field.annotation if field else Any
        elif origin in (Union, UnionType) and (member := _tagged(arguments, part)):
            kind = member
        elif isinstance(part, int):
            path, kind, field = f"{path}[{part}]", arguments[0] if arguments else Any, None
        else:
            path, kind, field = f"{path}.{part}", arguments[-1] if arguments else Any, None
    return path.removeprefix("."), table, field


def _stated(annotation: Any) -> Any:
    """Of a table that may be left out, the table."""
    parts = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else ()
    others = [part for part in parts if part is not type(None)]
    return others[0] if len(others) == 1 else annotation


def _tagged(members: tuple[Any, ...], tag: int | str) -> type[BaseModel] | None:
    for member in members:
        if isinstance(member, type) and issubclass(member, BaseModel):
            annotation = member.model_fields["model"].annotation
            if tag in get_args(annotation):
                return member
    return None


def _known(key: str, table: type[BaseModel]) -> str:
    names = list(table.model_fields)
    close = get_close_matches(key, names, n=1)
    return f"did you mean {close[0]}?" if close else f"allowed are {', '.join(names)}"


def _how_to_add(path: str, field: FieldInfo | None) -> str:
    key = path.rsplit(".", 1)[-1]
    if field is None:
        return "another entry is wanted"
    if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
        return f"add the table [{path}] with {', '.join(field.annotation.model_fields)}"
    if tables := _tables_of(field.annotation):
        header = f"[[{path}]]" if get_origin(field.annotation) is tuple else f"[{path}.NAME]"
        return f"add a table {header} with {', '.join(tables.model_fields)}"
    quantities = [entry.example for entry in field.metadata if isinstance(entry, Quantity)]
    examples = quantities or field.examples or get_args(field.annotation)
    return f"add it, such as {key} = {_written(examples[0])}" if examples else f"add it: {key} = ..."


def _tables_of(annotation: Any) -> type[BaseModel] | None:
    """What a table of tables, or an array of them, is made of."""
    arguments = get_args(annotation)
    found = [a for a in arguments if isinstance(a, type) and issubclass(a, BaseModel)]
    return found[0] if found and get_origin(annotation) is not None else None


def _written(value: object) -> str:
    """As in the file, nearly; long values are cut."""
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
