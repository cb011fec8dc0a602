"""Where independent pieces of work are done: in this process, or by others.

Whoever has such pieces is handed a `Workers`, and need not know which it is.
"""

import pickle
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol, TypeVar

from updamp.effects.user_effect import effect_from_file
from updamp.hbm.compilation_cache import keep_compiled

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")


LOST = "a process was ended from outside, likely for want of memory; run again with fewer --jobs"


class WorkerLostError(RuntimeError):
    """A process that ended before its work. place: of the item that it was at, or that was next"""

    def __init__(self, place: int) -> None:
        super().__init__(_cannot_be_started_anew() or LOST)
        self.place = place


def _cannot_be_started_anew() -> str:
    """Why no process can begin: each reads the program that called for it anew (`multiprocessing`, "spawn"). "" where
    it can."""
    main = sys.modules["__main__"]
    path = getattr(main, "__file__", None)
    if path is None or getattr(main, "__spec__", None) is not None:  # a notebook, or python -m
        return ""
    if not Path(path).is_file():
        return (
            f"other processes cannot read this program anew, there is no file {path}: run it from one, or with jobs=1"
        )
    if "__main__" not in Path(path).read_text(encoding="utf-8", errors="replace"):
        return (
            f"other processes read {path} anew, to its end: put what calls for them under "
            'if __name__ == "__main__":, or use jobs=1'
        )
    return ""


class Workers(Protocol):
    """From items to what a function makes of each; results in the order of the items."""

    def __call__(
        self, function: Callable[[S, T], R], shared: S, items: Sequence[T], done: Callable[[int, R], None]
    ) -> list[R]:
        """function: of a module, so that other processes find it; done: called here with the place of an item that is
        done and its result

        raises: what the function raises; WorkerLostError
        """


def here(function: Callable[[S, T], R], shared: S, items: Sequence[T], done: Callable[[int, R], None]) -> list[R]:
    """In this process, one after the other."""
    found = []
    for place, item in enumerate(items):
        found.append(function(shared, item))
        done(place, found[-1])
    return found


@dataclass(frozen=True)
class Elsewhere:
    """By an executor of processes, such as `concurrent.futures.ProcessPoolExecutor` or that of a Dask client.

    own: files of the user's own effects, which the other processes read too
    keep_compiled: whether they keep compiled contact laws, and use what is kept
    """

    executor: Executor
    own: tuple[Path, ...] = ()
    keep_compiled: bool = False

    def __call__(
        self, function: Callable[[S, T], R], shared: S, items: Sequence[T], done: Callable[[int, R], None]
    ) -> list[R]:
        task = _Task(function, self.own, self.keep_compiled, pickle.dumps(shared))
        futures: dict[Future[R], int] = {}
        found: dict[int, R] = {}
        place = 0
        try:
            for place, item in enumerate(items):
                futures[self.executor.submit(task, pickle.dumps(item))] = place
            for future in as_completed(futures):
                place = futures[future]
                found[place] = future.result()
                done(place, found[place])
        except BrokenProcessPool as error:
            raise WorkerLostError(place) from error
        finally:  # an interruption does not wait for what has not begun
            for future in futures:
                future.cancel()
        return [found[place] for place in range(len(items))]


@dataclass(frozen=True)
class LongestFirst:
    """What takes longest is begun with, or one of the workers would be busy with it alone in the end.

    effort: of an item; larger for one that is likely to take longer
    """

    workers: Workers
    effort: Callable[[Any], float]

    def __call__(
        self, function: Callable[[S, T], R], shared: S, items: Sequence[T], done: Callable[[int, R], None]
    ) -> list[R]:
        order = sorted(range(len(items)), key=lambda place: -self.effort(items[place]))
        in_order = [items[place] for place in order]
        try:
            found = self.workers(function, shared, in_order, lambda i, result: done(order[i], result))
        except WorkerLostError as error:
            raise WorkerLostError(order[error.place]) from error
        by_place = dict(zip(order, found, strict=True))
        return [by_place[place] for place in range(len(items))]


@dataclass(frozen=True)
class _Task:
    """What another process does. shared: pickled, for all items. A user's effect can be unpickled only where its file
    has been read, so items come as bytes too."""

    function: Callable[[Any, Any], Any]
    own: tuple[Path, ...]
    keep_compiled: bool
    shared: bytes

    def __call__(self, item: bytes) -> Any:
        _prepared(self.own, self.keep_compiled)
        return self.function(_unpickled(self.shared), pickle.loads(item))


@lru_cache(maxsize=1)
def _prepared(own: tuple[Path, ...], kept: bool) -> None:
    """Once a process."""
    if kept:
        keep_compiled()
    for path in own:
        effect_from_file(path)


@lru_cache(maxsize=2)
def _unpickled(shared: bytes) -> Any:
    return pickle.loads(shared)
