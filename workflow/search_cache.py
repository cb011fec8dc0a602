"""What a search has found so far, on disk, so that one that was stopped goes on where it was."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import FitRunner, FitTask, FittedCandidate, OnFitted, without_branches
from updamp.diagnosis.criteria import Criteria
from updamp.workflow.kept_results import Message, ResultKey, made_with, read_result, write_result

T = TypeVar("T")
# Bytes of a file's name: file systems take 255, of which endings and a file that is being written need some. Characters
# that are kept of a longer one, four bytes each at most.
_LONGEST, _READABLE = 200, 40


@dataclass(frozen=True)
class SearchCache:
    """folder: of the files; key: of everything that the results depend on; message: takes a sentence for the user"""

    folder: Path
    key: ResultKey
    message: Message

    def without_stale(self) -> "SearchCache":
        """Files of another version of updamp are removed; those of other inputs stay until they are written over."""
        codes = {path: made_with(path) for path in self.folder.glob("*.pickle")}
        stale = [path for path, made_by in codes.items() if made_by.get("code") != self.key.code]
        for path in stale:
            path.unlink()
        if stale:
            self.message(f"the search kept in {self.folder} was made by another version of updamp: begun anew")
        elif any(made_by["inputs"] != self.key.inputs for made_by in codes.values()):
            self.message(
                f"the search kept in {self.folder} is of another rig file, measurement or other options: begun anew"
            )
        return self

    def read(self, name: str) -> Any | None:
        """None where nothing is known, or what is known belongs to something else or was not written to its end."""
        path = self._path(name)
        if path.is_file() and made_with(path).get("inputs") != self.key.inputs:
            return None
        return read_result(path, self.key, self.message)

    def once(self, name: str, made: Callable[[], T]) -> T:
        """What is known, else what `made` gives, which is kept; never None"""
        known: T | None = self.read(name)
        if known is None:
            known = made()
            self.write(name, known)
        return known

    def write(self, name: str, value: Any) -> None:
        write_result(self._path(name), self.key, value)

    def _path(self, name: str) -> Path:
        """Of many effects the names are too long for a file's: their beginning, and what stands for all of it."""
        plain = name.replace(", ", "__").replace(" ", "_")
        if len(plain.encode()) > _LONGEST:
            plain = f"{plain[:_READABLE]}_{hashlib.sha256(plain.encode()).hexdigest()[:16]}"
        return self.folder / f"{plain}.pickle"


@dataclass(frozen=True)
class CachedFits:
    """Fits of candidate models. Those in the cache are not made again; what `runner` makes is written there.

    What a task came to is kept as a tuple of one: that it came to nothing is known too.
    """

    cache: SearchCache
    runner: FitRunner

    def __call__(
        self, start: Baseline, criteria: Criteria, tasks: Sequence[FitTask], done: OnFitted
    ) -> list[FittedCandidate | None]:
        again = f"attempt_{start.attempt + 1}__" if start.attempt else ""
        there = "__".join(e.name for e in start.fitted.parametrisation.effects)
        # one more beside an effect is not the same task as both at once: it is held against the model with the first
        prefix = f"{again}{there}__and__" if there else again
        known: list[tuple[FittedCandidate | None] | None] = [self.cache.read(prefix + a.name) for a in tasks]

        def kept(task: FitTask, result: FittedCandidate | None) -> None:
            lean = result and result.with_fit(without_branches(result.refit.fitted))
            self.cache.write(prefix + task.name, (lean,))
            done(task, result)

        missing = [a for a, before in zip(tasks, known, strict=True) if before is None]
        made = iter(self.runner(start, criteria, missing, kept))
        return [next(made) if before is None else before[0] for before in known]
