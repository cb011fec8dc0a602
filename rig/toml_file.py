"""A TOML file that a person has written: its text in UTF-8, its tables, its kind; mistakes are told with the line and
what is likely wrong there, and who hands over the wrong kind of file is told so, not its unknown keys."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from updamp.rig.errors import RigError

UTF_16 = (b"\xff\xfe", b"\xfe\xff")
# kind -> the command that takes it
KINDS: Mapping[str, str] = {
    "rig file": "updamp run, or updamp compare with a measurement",
    "measurement": "updamp compare RIG MEASUREMENT",
    "design study": "updamp design",
    "parameter study": "updamp study",
}
_PLACE = re.compile(r" ?\(at (?:line (\d+), column (\d+)|end of document)\)")


def read_toml(path: Path, wanted: str, failure: type[ValueError] = RigError, kind: str = "") -> dict[str, Any]:
    """A TOML file as it is.

    wanted: what to give in its place where it cannot be used; kind: of KINDS, where only that will do
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


def read_text(path: Path, wanted: str, failure: type[ValueError]) -> str:
    """The file's text without a byte order mark. wanted: what to give in its place, for the messages

    raises: `failure` where the file is missing, a folder, not to be read, or no text in UTF-8: with the line
    """
    try:
        content = path.read_bytes() if not path.is_dir() else None
    except FileNotFoundError:
        raise failure(f"{path}: no such file; give {wanted}") from None
    except OSError as error:
        raise failure(f"{path}: cannot be read: {error.strerror}; give {wanted}") from None
    if content is None:
        raise failure(f"{path}: cannot be read: it is a folder; give {wanted}")
    if content.startswith(UTF_16):
        raise failure(f"{path}: the text is UTF-16; save it as UTF-8")
    if b"\0" in content:
        raise failure(f"{path}: no text (it has bytes of zero); give {wanted}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise failure(
            f"{path}: line {line} has the byte 0x{content[error.start]:02x}, which is no UTF-8: no text, or one of "
            f"another encoding (Latin-1, Windows); save it as UTF-8, or give {wanted}"
        ) from None


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
