"""What a search has found so far, on disk, so that one that was stopped goes on where it was."""

import hashlib
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from updamp.diagnosis.candidate_models.attempts import Attempt, Bench, Done, Result, without_branches
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.criteria import Criteria


@dataclass(frozen=True)
class Memory:
    """folder: of the files; digest: of everything that the results depend on"""

    folder: Path
    digest: str

    def recall(self, name: str) -> Any | None:
        """None where nothing is known, or what is known belongs to something else or was not written to its end."""
        path = self._path(name)
        if not path.is_file():
            return None
        try:
            digest, value = pickle.loads(path.read_bytes())
        except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, ValueError):
            return None
        return value if digest == self.digest else None

    def keep(self, name: str, value: Any) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        partial = self._path(name).with_suffix(".partial")
        partial.write_bytes(pickle.dumps((self.digest, value)))
        partial.replace(self._path(name))

    def _path(self, name: str) -> Path:
        return self.folder / f"{name.replace(', ', '__').replace(' ', '_')}.pickle"


def digest_of(parts: Sequence[str]) -> str:
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


@dataclass(frozen=True)
class Remembering:
    """A bench that asks the memory first, and tells it what was found."""

    memory: Memory
    bench: Bench

    def __call__(
        self, start: Baseline, criteria: Criteria, attempts: Sequence[Attempt], done: Done
    ) -> list[Result | None]:
        beside = "".join(f"{e.name}__" for e in start.fitted.parametrisation.effects)
        known: list[Result | None] = [self.memory.recall(beside + a.name) for a in attempts]

        def kept(attempt: Attempt, result: Result | None) -> None:
            if result is not None:
                self.memory.keep(beside + attempt.name, result.with_fit(without_branches(result.refit.fitted)))
            done(attempt, result)

        missing = [i for i, result in enumerate(known) if result is None]
        made = self.bench(start, criteria, [attempts[i] for i in missing], kept)
        for i, result in zip(missing, made, strict=True):
            known[i] = result
        return known
