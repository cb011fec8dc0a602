"""The text of a rig file with effects put in and taken out: comments, order and spelling of all else stay."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import AoT, Array, InlineTable, Table


@dataclass(frozen=True)
class EffectText:
    """An effect as the file states it. values: text with a unit, or plain numbers; file: of a user's own effect, ""
    for one that updamp knows"""

    name: str
    values: Mapping[str, str | float]
    origin: str
    file: str = ""


def effect_names(text: str) -> tuple[str, ...]:
    return tuple(str(entry["name"]) for entry in _effects(tomlkit.parse(text)))


def is_calibrated(text: str) -> bool:
    return "calibration" in tomlkit.parse(text)


def with_effect(text: str, effect: EffectText) -> str:
    """The effect at the end of the file's effects, or with these values in the place of the one of its name."""
    document = tomlkit.parse(text)
    names = [entry["name"] for entry in _effects(document)]
    if effect.name in names:
        _state(document["effects"][names.index(effect.name)], effect)
    else:
        _append(document, effect)
    return tomlkit.dumps(document)


def without_effects(text: str, names: Sequence[str]) -> str:
    document = tomlkit.parse(text)
    entries = _effects(document)
    for place in reversed(range(len(entries))):
        if entries[place]["name"] in names:
            del entries[place]
    if "effects" in document and not entries:
        del document["effects"]
    return _ended(document)


def with_calibration(text: str, factors: Mapping[str, float], origin: str) -> str:
    """The factors on top of those that are there: a fit finds them about the rig file as it is."""
    document = tomlkit.parse(text)
    if "calibration" not in document:
        _end_with_empty_line(document, document)
        document["calibration"] = tomlkit.table()
    table: Any = document["calibration"]
    table["origin"] = origin
    for name, factor in factors.items():
        table[name] = float(f"{factor * float(table.get(name, 1.0)):.6g}")
    return tomlkit.dumps(document)


def with_values(text: str, values: Mapping[str, Any]) -> str:
    """Values by dotted path, such as {"load.pull": "900 N"}; the comment behind each stays. Tables that are missing are
    added; effects have `with_effect`."""
    document = tomlkit.parse(text)
    for path, value in values.items():
        *tables, last = path.split(".")
        here: Any = document
        for name in tables:
            if name not in here:
                here[name] = tomlkit.table()
            here = here[name]
        item = tomlkit.item(value)
        if last in here:
            item.trivia.comment_ws, item.trivia.comment = (
                here.item(last).trivia.comment_ws,
                here.item(last).trivia.comment,
            )
        here[last] = item
    return tomlkit.dumps(document)


def without_calibration(text: str) -> str:
    document = tomlkit.parse(text)
    document.pop("calibration", None)
    return _ended(document)


def moved(text: str, source: Path, target: Path) -> str:
    """The text with its relative names of files changed, for a copy of the file in another folder."""
    if source.resolve() == target.resolve():
        return text
    document = tomlkit.parse(text)
    tables: list[Any] = [(entry, "file") for entry in _effects(document)]
    pressure: Any = document.get("contact", {}).get("pressure", {})
    tables += [(table, "map") for table in (pressure, pressure.get("left", {}), pressure.get("right", {}))]
    for table, key in tables:
        if key in table and not Path(table[key]).is_absolute():
            table[key] = os.path.relpath(source.resolve() / table[key], target.resolve())
    return tomlkit.dumps(document)


def _effects(document: tomlkit.TOMLDocument) -> Any:
    return document.get("effects", [])


def _append(document: tomlkit.TOMLDocument, effect: EffectText) -> None:
    entries = _effects(document)
    if isinstance(entries, Array):  # effects = [{ ... }]
        inline = tomlkit.inline_table()
        _state(inline, effect)
        entries.append(inline)
        return
    table = tomlkit.table()
    _state(table, effect)
    if isinstance(entries, AoT):
        if list(document)[-1] == "effects":
            _end_with_empty_line(document, entries[-1])
        else:
            table.add(tomlkit.nl())
        entries.append(table)
        return
    _end_with_empty_line(document, document)
    tables = tomlkit.aot()
    tables.append(table)
    document["effects"] = tables


def _state(table: Table | InlineTable, effect: EffectText) -> None:
    values = tomlkit.inline_table()
    values.update(effect.values)
    table["name"] = effect.name
    if effect.file:
        table["file"] = effect.file
    table["values"] = values
    table["origin"] = effect.origin


def _ended(document: tomlkit.TOMLDocument) -> str:
    """Without the empty lines that stood before what was taken off."""
    return tomlkit.dumps(document).rstrip("\n") + "\n"


def _end_with_empty_line(document: tomlkit.TOMLDocument, last: tomlkit.TOMLDocument | Table) -> None:
    """last: what ends the document, which the line is put into"""
    text = tomlkit.dumps(document)
    for _ in range(2 - (len(text) - len(text.rstrip("\n")))):
        last.add(tomlkit.nl())
