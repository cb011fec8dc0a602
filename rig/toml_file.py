"""A TOML file read, and its mistakes told with the line and what is likely wrong there."""

import re
import tomllib
from pathlib import Path
from typing import Any

from updamp.rig.errors import RigError
from updamp.rig.file_kinds import check_kind
from updamp.rig.text_file import read_text

_PLACE = re.compile(r" ?\(at (?:line (\d+), column (\d+)|end of document)\)")


def read_toml(path: Path, wanted: str, failure: type[ValueError] = RigError, kind: str = "") -> dict[str, Any]:
    """A TOML file as it is.

    wanted: what to give in its place where it cannot be used; kind: of file_kinds.KINDS, where only that will do
    raises: `failure` where it cannot be read, is empty or another kind of file
    """
    text = read_text(path, wanted, failure)
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise failure(f"{path}: not valid TOML: {toml_mistake(text, str(error))}") from None
    if not table:
        raise failure(f"{path}: the file is empty; give {wanted}")
    if kind:
        check_kind(path, table, kind, failure)
    return table


def toml_mistake(text: str, message: str) -> str:
    """The parser's message with the line it means, and what to do where that is known."""
    place = _PLACE.search(message)
    what = _PLACE.sub("", message)
    lines = text.splitlines() or [""]
    number = int(place[1]) if place and place[1] else len(lines)
    line = lines[number - 1].strip() if number <= len(lines) else ""
    hint = _hint(line, what, lines[:number])
    return f"line {number} is {line[:60]!r}: {what}{f'; {hint}' if hint else ''}"


def _hint(line: str, message: str, above: list[str]) -> str:
    key, _, value = (part.strip() for part in line.partition("="))
    value = value.split("#")[0].strip()
    if "overwrite" in message or "twice" in message or "declare" in message.lower():
        return f"{(key or line)} stands there twice; keep one"
    if value.count('"') % 2 or any(one.split("#")[0].count('"') % 2 for one in above[-1:]):
        return "a quote is missing: text begins and ends with one"
    if value.endswith(";"):
        return "leave out the semicolon: a line ends without"
    if re.fullmatch(r"[+-]?\d+,\d+", value):
        return f"numbers have a decimal point: {value.replace(',', '.')}"
    if re.fullmatch(r"[+-]?[\d.]+\s*[A-Za-z].*", value):
        return f'a value with a unit stands in quotes: {key} = "{value}"'
    if "=" not in line and line and not line.startswith("["):
        return 'wanted is key = value, such as height = "150 mm"'
    return ""
