"""How processes end that are asked to: soon, with their work kept, and none left behind.

Whoever is asked by a signal may be in the midst of compiled code (a factorisation, JAX, numba) for a minute, where
Python does not get to its handlers. So a thread of each process waits for the signal too, or for the end of its parent;
where the process has not come to its own end in time, the thread ends it.
"""

import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import active_children
from multiprocessing.connection import Connection, wait
from types import FrameType
from typing import Any, ParamSpec, TypeVar

import psutil

P = ParamSpec("P")
R = TypeVar("R")

# A command ends within 10 s of SIGTERM or Ctrl-C: workers store what they have and end, those that do not are ended,
# then the command comes to its end, or is ended too.
GRACE_OF_WORKER, GRACE_OF_WORKERS, GRACE_OF_COMMAND = 4.0, 5.0, 8.0  # s
INTERRUPTED = 130  # as shells have it: 128 + SIGINT


RAISED_AGAIN = 1.0  # s
_heard = threading.Event()


def heard() -> None:
    """Whoever begins to end things on a KeyboardInterrupt says so: until then it is raised again and again, since one
    that was raised in a finaliser or in a library's callback is lost."""
    _heard.set()


class Worker:
    """A worker process. `asked` is set by SIGTERM, and when its parent closes the pipe or is gone: it stores what it
    has and ends; after `grace` [s] it is ended. Ctrl-C reaches it too, and is for the parent to deal with."""

    def __init__(self, alive: Connection, grace: float = GRACE_OF_WORKER) -> None:
        if select.select([alive.fileno()], [], [], 0)[0]:  # asked while it was still loading: it has nothing to store
            os._exit(1)
        self.asked = threading.Event()
        self._grace = grace
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        told = _signals(signal.SIGTERM)
        threading.Thread(target=self._watch, args=(alive, told), name="ending", daemon=True).start()

    def _watch(self, alive: Connection, told: int) -> None:
        """Nothing is ever sent through `alive`: it can be read from when its other end is closed."""
        select.select([alive.fileno(), told], [], [])
        self.asked.set()
        _after(self._grace, lambda: os._exit(1))


def end_children(grace: float = GRACE_OF_WORKERS) -> None:
    """Wait for the processes that this one has begun by `multiprocessing`, and end those that are there after `grace`
    [s]: one may be loading libraries still, and hear nothing."""
    heard()
    ends = time.monotonic() + grace
    children = {child.sentinel: child for child in active_children()}
    while children and (left := ends - time.monotonic()) > 0:
        for sentinel in wait(list(children), left):
            del children[sentinel]  # type: ignore[arg-type]
    for child in children.values():
        child.kill()


class DeafProcesses(ProcessPoolExecutor):
    """Its processes, which begin with a task, do not hear Ctrl-C, not even while they load: it is for their parent."""

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().submit(fn, *args, **kwargs)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Command:
    """The process of a command. SIGTERM and Ctrl-C raise KeyboardInterrupt until that is `heard`; further ones change
    nothing. After `grace` [s] the process is ended with all that it started, and `last_words` are said."""

    def __init__(self, last_words: Callable[[], str], grace: float = GRACE_OF_COMMAND) -> None:
        self._grace, self._last_words = grace, last_words
        _heard.clear()
        self._before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
        self._hook, sys.unraisablehook = sys.unraisablehook, self._lost
        self._told = _signals(*self._before, handler=self._interrupt)
        threading.Thread(target=self._watch, name="ending", daemon=True).start()

    def over(self) -> None:
        """The command's work is done: signals are what they were. A process that is ending is watched to its end."""
        if _heard.is_set():
            return
        sys.unraisablehook = self._hook
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        if not _heard.is_set():
            raise KeyboardInterrupt

    def _lost(self, found: Any) -> None:
        """What cannot be raised where it happened: an interruption comes again, of others the user is told."""
        if not issubclass(found.exc_type, KeyboardInterrupt):
            self._hook(found)

    def _watch(self) -> None:
        select.select([self._told], [], [])
        ends, main = time.monotonic() + self._grace, threading.main_thread().ident
        while not _heard.wait(RAISED_AGAIN) and time.monotonic() < ends:
            assert main is not None, "the main thread has begun"
            signal.pthread_kill(main, signal.SIGTERM)
        _after(ends - time.monotonic(), self._end)

    def _end(self) -> None:
        os.write(2, f"{self._last_words()}\n".encode())
        for child in psutil.Process().children(recursive=True):
            try:
                child.kill()
            except psutil.Error:  # it ended meanwhile
                continue
        os._exit(INTERRUPTED)


def _signals(*numbers: int, handler: Callable[[int, FrameType | None], None] = lambda *_: None) -> int:
    """Handle the signals; returns what can be read from as soon as one of them has come, whatever Python is at."""
    told, tells = os.pipe()
    os.set_blocking(tells, False)
    signal.set_wakeup_fd(tells, warn_on_full_buffer=False)
    for number in numbers:
        signal.signal(number, handler)
    return told


def _after(seconds: float, end: Callable[[], None]) -> None:
    time.sleep(max(seconds, 0.0))
    end()
