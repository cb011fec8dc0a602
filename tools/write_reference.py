"""Writes the pages of the reference that follow from the code: keys of the input files, and the command line.

.venv/bin/python tools/write_reference.py docs/reference/generated        # `make docs` does it too
"""

import sys
from collections.abc import Iterator, Mapping
from inspect import cleandoc
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from typer.testing import CliRunner

from updamp.measurement.measurement_file import MeasurementFile
from updamp.pipeline import app
from updamp.rig.fields import Quantity
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig

INPUTS: Mapping[str, tuple[str, type[BaseModel]]] = {
    "rig_file.md": ("Keys of a rig file", Rig),
    "modal_rig_file.md": ("Keys of a rig file that gives modes", ModalRig),
    "measurement_file.md": ("Keys of measurement.toml", MeasurementFile),
}


def write_reference(folder: Path) -> None:
    """A page each, made anew."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, (title, model) in INPUTS.items():
        (folder / name).write_text("\n".join([f"# {title}", "", *_tables(model, "")]) + "\n", encoding="utf-8")
    (folder / "command_line.md").write_text(_command_line(), encoding="utf-8")


def _tables(model: type[BaseModel], path: str) -> Iterator[str]:
    """The keys of a table, then the tables within it."""
    yield from ((f"## `[{path}]`", "") if path else ())
    yield from ("```text", *cleandoc(model.__doc__ or "").splitlines(), "```", "")
    yield from ("| key | value | wanted |", "|---|---|---|")
    for name, field in model.model_fields.items():
        yield f"| `{name}` | {_value(field)} | {'yes' if field.is_required() else 'no'} |"
    yield ""
    for name, field in model.model_fields.items():
        for inner, of_many in _models(field.annotation):
            if inner.__name__ != "Calibration" and inner.__name__ != "RigEffect":  # docs/effects.md
                yield from _tables(inner, f"{path}.{name}{'.NAME' if of_many else ''}".lstrip("."))


def _models(annotation: Any, of_many: bool = False) -> list[tuple[type[BaseModel], bool]]:
    """Tables within an annotation, and whether it holds several under names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [(annotation, of_many)]
    many = of_many or getattr(annotation, "__origin__", None) in (Mapping, dict)
    return [found for part in get_args(annotation) for found in _models(part, many)]


def _value(field: FieldInfo) -> str:
    return _described(field.annotation, tuple(field.metadata), tuple(field.examples or ())).replace("|", "\\|")


def _described(annotation: Any, notes: tuple[Any, ...], examples: tuple[Any, ...]) -> str:
    """In words. notes: what annotates the value (quantities, bounds)"""
    while get_origin(annotation) is Annotated or type(None) in get_args(annotation):
        notes += tuple(getattr(annotation, "__metadata__", ()))
        annotation = next(part for part in get_args(annotation) if part is not type(None))
    for inner in (note for note in notes if isinstance(note, FieldInfo)):
        notes, examples = (*notes, *inner.metadata), (*examples, *(inner.examples or ()))
    such = f", such as `{examples[0]!r}`".replace("'", '"') if examples else ""
    if quantity := next((note for note in notes if isinstance(note, Quantity)), None):
        allowed = f", {quantity.allowed}" if quantity.allowed else ""
        return f'text with a unit, such as `"{quantity.example}"`{allowed}'
    if _models(annotation):
        return "a table, below"
    if literals := [part for part in get_args(annotation) if isinstance(part, str)]:
        return "one of " + ", ".join(f'`"{one}"`' for one in literals)
    if get_origin(annotation) is tuple:
        return f"a list{such}" if such else f"a list, each {_described(get_args(annotation)[0], (), ())}"
    words = {int: "a whole number", float: "a number", str: "text", bool: "true or false"}.get(annotation)
    return f"{words or 'a table of values'}{such}{_bounds(notes)}"


def _bounds(notes: tuple[Any, ...]) -> str:
    words = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most", "multiple_of": "a multiple of"}
    found = [f"{word} {getattr(n, k)}" for n in notes for k, word in words.items() if getattr(n, k, None) is not None]
    return f", {' and '.join(dict.fromkeys(found))}" if found else ""


def _command_line() -> str:
    lines = ["# The command line", "", "`updamp COMMAND --help` says the same.", ""]
    for command in app.registered_commands:
        name = command.name or command.callback.__name__.replace("_", "-")  # type: ignore[union-attr]
        said = CliRunner().invoke(app, [name, "--help"], prog_name="updamp", env={"COLUMNS": "100"}).output
        lines += [f"## updamp {name}", "", "```text", said.strip(), "```", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    write_reference(Path(sys.argv[1]))
