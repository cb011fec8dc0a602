"""Processes with one thread each, for as long as a context lasts; none of them outlives the process that started it.

`chosen_workers` are those that a command was asked for: this process, several of this machine, or those of a Dask
scheduler.
"""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from updamp.hbm.compilation_cache import keep_compiled, keeps_compiled
from updamp.parallel.ending import DeafProcesses, Worker, end_children
from updamp.parallel.resources import checked_workers, environment, thread_limits
from updamp.parallel.workers import Elsewhere, Workers, here

_PATIENCE = 30  # s, with a Dask scheduler that has no workers yet


@contextmanager
def processes(number: int) -> Iterator[ProcessPoolExecutor]:
    """They start with the first task, and end at once where the context is left by an error or an interruption, or
    this process is gone."""
    context = get_context("spawn")  # forking a process that has threads (MKL, JAX) can hang
    alive, held = context.Pipe(duplex=False)
    with held, alive, environment(thread_limits(1)):
        pool = DeafProcesses(number, context, _begin, (alive, keeps_compiled()))
        try:
            yield pool
        except BaseException:
            held.close()
            pool.shutdown(wait=False, cancel_futures=True)
            end_children(grace=1.0)
            raise
        pool.shutdown()


def _begin(alive: Connection, kept: bool) -> None:
    """Of a worker. What it is at is not stored in parts: there is nothing to wait for when it is to end."""
    Worker(alive, grace=0.0)
    if kept:
        keep_compiled()


@contextmanager
def chosen_workers(jobs: int, scheduler: str = "", own: tuple[Path, ...] = ()) -> Iterator[Workers]:
    """jobs: processes of this machine; scheduler: address of a Dask scheduler whose workers replace them, "" for none
    own: files of the user's own effects, which the other processes read too

    raises: ValueError where Dask is not installed or no worker comes, or for more processes than the memory holds
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
    elif checked_workers(jobs) > 1:
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
