"""The workers that a command was asked for: this process, several of this machine, or those of a Dask scheduler."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from updamp.hbm.compilation_cache import keeps_compiled
from updamp.parallel.processes import processes
from updamp.parallel.workers import Elsewhere, Workers, here

_PATIENCE = 30  # s, with a Dask scheduler that has no workers yet


@contextmanager
def chosen_workers(jobs: int, scheduler: str = "", own: tuple[Path, ...] = ()) -> Iterator[Workers]:
    """jobs: processes of this machine; scheduler: address of a Dask scheduler whose workers replace them, "" for none
    own: files of the user's own effects, which the other processes read too

    raises: ValueError where Dask is not installed or no worker comes
    """
    own, kept = tuple(path.resolve() for path in own), keeps_compiled()
    if scheduler:
        try:
            from distributed import Client
        except ImportError as error:
            raise ValueError(
                "--scheduler needs Dask: install it with `pip install 'updamp[cluster]'`, on the workers too"
            ) from error
        with Client(scheduler) as client:
            _wait_for_workers(client, scheduler)
            yield Elsewhere(client.get_executor(pure=False), own, kept)
    elif jobs > 1:
        with processes(jobs) as pool:
            yield Elsewhere(pool, own, kept)
    else:
        yield here


def _wait_for_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError as error:
        raise ValueError(
            f"--scheduler {address}: no worker has come in {_PATIENCE} s; start one: dask worker {address}"
        ) from error
