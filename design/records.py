"""Records of designs: one small file each, there as soon as the design is solved, whole or not at all."""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

DONE, PARTLY, FAILED, BROKEN = "done", "partly", "failed", "error"


@dataclass(frozen=True)
class Record:
    """number: of the design; key: hash of all that it was made from; setup: of what all designs of a study share
    values: of the variables, in their units
    outcome: "done"; "partly" where some responses are not known; "failed" where none is, with the reason;
        "error" for a mistake in the program: such a design is solved again
    responses: in their units, None where not known; unknown: name -> reason; routes: peak -> how it was found
    executed: stages that were computed, not found; seconds: wall time
    """

    key: str
    setup: str
    values: Mapping[str, float]
    outcome: str
    responses: Mapping[str, float | None]
    reason: str = ""
    unknown: Mapping[str, str] = field(default_factory=dict)
    routes: Mapping[str, str] = field(default_factory=dict)
    executed: tuple[str, ...] = ()
    seconds: float = 0.0
    number: int = 0


class RecordFolder:
    """All records in a folder, `<number>.json`. One process writes."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._by_number = {record.number: record for record in _read_all(folder)}
        self._by_key = {record.key: record for record in self._by_number.values()}
        self._numbers = {key: record.number for key, record in self._by_key.items()}
        self._lowest_free = 1

    def find(self, key: str) -> Record | None:
        """None too where a mistake in the program ended it: worth another try."""
        found = self._by_key.get(key)
        return found if found is not None and found.outcome != BROKEN else None

    def number(self, key: str) -> int:
        """That of its record; of a design without one the lowest that is free, which is its own from now on."""
        if key not in self._numbers:
            while self._lowest_free in self._by_number:
                self._lowest_free += 1
            self._numbers[key] = self._lowest_free
            self._lowest_free += 1
        return self._numbers[key]

    def add(self, record: Record) -> Record:
        """returns: with its number"""
        number = self.number(record.key)
        numbered = replace(record, number=number)
        self.folder.mkdir(parents=True, exist_ok=True)
        _write_whole(self.folder / f"{number:06d}.json", json.dumps(asdict(numbered), allow_nan=False, indent=1))
        self._by_number[number] = self._by_key[record.key] = numbered
        return numbered

    def of_setup(self, setup: str) -> tuple[Record, ...]:
        """By number."""
        return tuple(record for _, record in sorted(self._by_number.items()) if record.setup == setup)

    def __len__(self) -> int:
        return len(self._by_number)


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """No other process of this machine writes records meanwhile; the lock goes with the process that holds it.

    raises: ValueError where one does
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"{folder}: another study is at work in this folder; wait for it, or give --out") from None
        yield


def read_record(folder: Path, number: int) -> Record:
    """raises: ValueError naming the numbers there are"""
    found = {record.number: record for record in _read_all(folder)}
    if number not in found:
        known = f"there are {min(found)} to {max(found)}" if found else "there is none"
        raise ValueError(f"{folder}: no design {number}; {known}")
    return found[number]


def _read_all(folder: Path) -> Iterator[Record]:
    for path in sorted(folder.glob("[0-9]*.json")):
        try:
            stated: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            yield Record(**{**stated, "executed": tuple(stated["executed"])})
        except (ValueError, TypeError, KeyError):  # not one of ours: solved again, under another number
            continue


def _write_whole(path: Path, text: str) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    with temporary.open("w", encoding="utf-8") as file:
        file.write(text + "\n")
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
