"""Files made from stage products for people and other programs: made again only when their sources have changed."""

import hashlib
import json
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path


class Outputs:
    """Remembers in one file which key each output was made with."""

    def __init__(self, folder: Path, record: Path) -> None:
        self.folder, self.record = folder, record
        self._keys: dict[str, str] = {}
        with suppress(OSError, ValueError):  # none yet, or not one of ours: everything is made anew
            self._keys = dict(json.loads(record.read_text(encoding="utf-8")))

    def make(self, name: str, sources: Iterable[str], version: int, write: Callable[[Path], object]) -> bool:
        """Let `write` make folder/name, unless it is there and was made from the same sources by the same version.

        sources: keys of the stage products that go in, or anything else that does, as text
        returns: whether it was made
        """
        path = self.folder / name
        key = hashlib.sha256(json.dumps([version, *sources]).encode()).hexdigest()
        if self._keys.get(name) == key and path.exists():
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path)
        self._keys[name] = key
        self.record.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.record.with_suffix(".tmp")
        temporary.write_text(json.dumps(self._keys, indent=1), encoding="utf-8")
        temporary.replace(self.record)
        return True
