"""Results on disk that only the code which made them may read: pickles behind a line that says what made them.

The line is JSON: {"code": ..., "inputs": ..., "sha256": of the pickle}. A file whose line is not the one that is wanted
is never unpickled.
"""

import hashlib
import json
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from updamp.parallel.whole_file import write_whole

Message = Callable[[str], None]

_LONGEST_LINE = 1000  # bytes; what is longer was not written here


@dataclass(frozen=True)
class ResultKey:
    """code: of the source that makes a result (`code_version`); inputs: digest of all else that it depends on"""

    code: str
    inputs: str


def inputs_digest(*parts: str) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def write_result(path: Path, key: ResultKey, value: Any) -> None:
    """The file appears whole or not at all; its folder is made when missing. raises: DiskError"""
    content = pickle.dumps(value)
    line = {"code": key.code, "inputs": key.inputs, "sha256": hashlib.sha256(content).hexdigest()}
    write_whole(path, json.dumps(line).encode() + b"\n" + content)


def read_result(path: Path, key: ResultKey, message: Message) -> Any | None:
    """None where there is none, or none that was made by the same code from the same inputs.

    message: called with a sentence where the file is there and is not used
    """
    if not path.is_file():
        return None
    made_by = made_with(path)
    if made_by.get("code") != key.code:
        message(f"{path}: kept by another version of updamp; made anew")
    elif made_by.get("inputs") != key.inputs:
        message(f"{path}: kept for other inputs; made anew")
    else:
        return _unpickled(path, made_by.get("sha256", ""), message)
    return None


def made_with(path: Path) -> Mapping[str, str]:
    """The first line of a file: "code", "inputs" and "sha256"; empty where it has none that can be read."""
    with path.open("rb") as file:
        line = file.readline(_LONGEST_LINE)
    try:
        found = json.loads(line)
    except ValueError:  # of an older version, or another file altogether
        return {}
    return found if isinstance(found, dict) else {}


def _unpickled(path: Path, wanted: str, message: Message) -> Any | None:
    _, _, content = path.read_bytes().partition(b"\n")
    if hashlib.sha256(content).hexdigest() != wanted:
        message(f"{path}: damaged; made anew")
        return None
    try:
        return pickle.loads(content)
    except Exception as error:  # whatever the classes of a user's own effect stumble over
        message(f"{path}: cannot be read ({type(error).__name__}: {error}); made anew")
        return None
