"""Processes with one thread each, for as long as a context lasts; none of them outlives the process that started it."""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection

from updamp.hbm.compilation_cache import keep_compiled, keeps_compiled
from updamp.parallel.ending import Worker, end_children
from updamp.parallel.resources import environment, thread_limits


@contextmanager
def processes(number: int) -> Iterator[ProcessPoolExecutor]:
    """They start with the first task, and end at once where the context is left by an error or an interruption, or
    this process is gone."""
    context = get_context("spawn")  # forking a process that has threads (MKL, JAX) can hang
    alive, held = context.Pipe(duplex=False)
    with held, alive, environment(thread_limits(1)):
        pool = ProcessPoolExecutor(number, context, _begin, (alive, keeps_compiled()))
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
