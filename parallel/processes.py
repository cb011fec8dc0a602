"""Processes with one thread each, for as long as a context lasts; none of them outlives the process that started it."""

import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection

from updamp.hbm.compilation_cache import keep_compiled, keeps_compiled
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
            pool.shutdown(wait=True, cancel_futures=True)
            raise
        pool.shutdown()


def _begin(alive: Connection, kept: bool) -> None:
    """Of a worker. An interruption from the keyboard reaches it too; it is for the parent to end it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
    if kept:
        keep_compiled()


def _end_with_parent(alive: Connection) -> None:
    """Nothing is ever sent: the other end is closed, by the parent or by its end."""
    try:
        alive.recv()
    except EOFError:
        os._exit(1)
