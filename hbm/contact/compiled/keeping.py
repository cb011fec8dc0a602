"""How functions are compiled by numba, and where what is compiled is kept.

Not in numba's own place beside the source, which may be read-only. The folder is named by a hash of the sources here:
numba itself would only see a change in the file of the function that is kept, not in those of the functions it calls.
Nothing is reordered (no fastmath), so that results differ as little between machines as those of compiled C do.

Processes that begin together compile each function once: one compiles, the others wait and read what it has kept.
"""

import fcntl
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from numba import config as numba_config

from updamp.hbm.compilation_cache import cache_folder

config: Any = numba_config  # its entries are made when it is loaded, and unknown to mypy


def inner(function: Callable[..., Any]) -> Any:
    """For functions that other compiled functions call: Python's way in is not compiled, a fifth of the time."""
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def kept(function: Callable[..., Any]) -> Any:
    """For functions that Python calls: kept between runs where there is a place that can be written to."""
    folder = _folder()
    if folder is None:
        return _compiled(function)
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        dispatcher = _compiled(function, cache=True)
    finally:
        config.CACHE_DIR = before
    return _one_at_a_time(dispatcher, folder / f"{function.__module__}.{function.__name__}.lock")


def _compiled(function: Callable[..., Any], **options: Any) -> Any:
    """A division by zero is infinite or not a number, as in numpy, and no error."""
    return numba.njit(error_model="numpy", **options)(function)


def _one_at_a_time(dispatcher: Any, lock: Path) -> Any:
    """`compile` of numba's dispatcher looks for what is kept first; here with the lock held, of all processes."""
    look_or_compile = dispatcher.compile

    def compile_alone(signature: Any) -> Any:
        with _held(lock):
            return look_or_compile(signature)

    dispatcher.compile = compile_alone
    return dispatcher


@contextmanager
def _held(lock: Path) -> Iterator[None]:
    """The system lets go of it where a process ends, however it ends."""
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _folder() -> Path | None:
    sources = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
    folder = cache_folder() / f"kernels-{hashlib.sha256(sources).hexdigest()[:12]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
