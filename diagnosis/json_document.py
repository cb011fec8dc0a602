"""A dataclass kept as a JSON file with the name of its schema."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from updamp.diagnosis.dataclass_json import decode, encode

T = TypeVar("T")


@dataclass(frozen=True)
class JsonDocument(Generic[T]):
    """kind: of the dataclass; schema: name and version in the file; command: that writes the file"""

    kind: type[T]
    schema: str
    command: str

    def to_json(self, value: T) -> dict[str, Any]:
        return {"schema": self.schema, **encode(value)}

    def from_json(self, content: dict[str, Any]) -> T:
        """raises: ValueError naming what is missing, unknown or of the wrong kind"""
        found = content.get("schema") if isinstance(content, dict) else None
        if found != self.schema:
            raise ValueError(
                f"schema is {found!r}, this version reads {self.schema!r}: write the file anew with '{self.command}'"
            )
        return decode(self.kind, {name: value for name, value in content.items() if name != "schema"})

    def write(self, path: Path, value: T) -> None:
        path.write_text(json.dumps(self.to_json(value), allow_nan=False, indent=1), encoding="utf-8")

    def read(self, path: Path) -> T:
        """raises: ValueError naming the file and what is wrong with it"""
        try:
            return self.from_json(json.loads(path.read_text(encoding="utf-8")))
        except ValueError as error:  # JSONDecodeError and UnicodeDecodeError are ValueErrors
            raise ValueError(f"{path}: {error}") from error
