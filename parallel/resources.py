"""Wall time and memory of a piece of work, child processes included."""

import os
import resource
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from types import TracebackType
from typing import ParamSpec, Self, TypeVar

import psutil
from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")
_GROUP = Path("/sys/fs/cgroup")
_BYTES_PER_MAXRSS = 1 if sys.platform == "darwin" else 1024


class Meter:
    """Context manager: seconds, interval and peak resident memory [bytes] of the work inside.

    Memory is that of the process `root` (default: this one) and all below it, sampled; where this process's own
    high-water mark rose meanwhile, the mark counts if it is larger, so that short spikes are not missed.
    """

    def __init__(self, root: int | None = None, every: float = 0.25) -> None:
        self.root, self.every = psutil.Process(root or os.getpid()), every
        self.started = self.ended = time.time()
        self.peak_memory = 0.0
        self._done = threading.Event()
        self._mark = _high_water_mark()

    def __enter__(self) -> Self:
        self.started = time.time()
        self._clock = time.perf_counter()
        self._mark = _high_water_mark()
        self._thread = threading.Thread(target=self._sample, name="memory meter", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._done.set()
        self._thread.join()
        self.ended = self.started + self.seconds
        if (mark := _high_water_mark()) > self._mark:
            self.peak_memory = max(self.peak_memory, mark)

    @property
    def seconds(self) -> float:
        """Since the start, or from start to end once it is over."""
        if self._done.is_set() and self.ended > self.started:
            return self.ended - self.started
        return time.perf_counter() - self._clock

    @property
    def interval(self) -> tuple[float, float]:
        return self.started, self.started + self.seconds

    def _sample(self) -> None:
        while True:
            self.peak_memory = max(self.peak_memory, _resident(self.root))
            if self._done.wait(self.every):
                return


def _resident(root: psutil.Process) -> float:
    total = 0.0
    try:
        family = [root, *root.children(recursive=True)]
    except psutil.Error:
        return total
    for process in family:
        try:
            total += process.memory_info().rss
        except psutil.Error:  # it ended meanwhile
            continue
    return total


def _high_water_mark() -> float:
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _BYTES_PER_MAXRSS)


def thread_limits(threads: int) -> Mapping[str, str]:
    """Environment that holds numpy's BLAS, MKL and JAX to so many threads; read when they are loaded.

    PJRT_NPROC is the size of XLA's own pool: without it XLA takes all processors, whatever XLA_FLAGS says. With one
    thread a computation runs where it is called: handed to another thread, it waits for its turn on a busy machine.
    """
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PJRT_NPROC")
    values = {name: str(threads) for name in names}
    if threads == 1:
        flags = os.environ.get("XLA_FLAGS", "").split()
        wanted = ("--xla_cpu_multi_thread_eigen=false", "intra_op_parallelism_threads=1")
        values["XLA_FLAGS"] = " ".join([*flags, *(flag for flag in wanted if flag not in flags)])
        values["JAX_CPU_ENABLE_ASYNC_DISPATCH"] = "0"
    return values


def on_one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Called with one thread of BLAS, whatever the process has: threads of many small products wait for each other,
    which takes up to twelve times as long where another program has the other processors."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        with threadpool_limits(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return called


def one_thread() -> None:
    """For this process, where the user has not set it otherwise: many small products, for which threads would wait for
    each other. Nothing once JAX is loaded: it would be for processes that this one starts, which then have other last
    digits."""
    if "jax" in sys.modules:
        return
    for name, value in thread_limits(1).items():
        os.environ.setdefault(name, value)


def one_thread_for_numpy() -> None:
    """Where a solver has threads of its own (`fem/solvers/`), if the user has not set it otherwise: numpy's would wait
    for work by turning in circles on the cores that the solver's want. Nothing once numpy is loaded."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Environment variables for the processes started inside."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def free_memory() -> float:
    """Memory [bytes] that processes may still take: of the machine, or of the control group of this one."""
    free = float(psutil.virtual_memory().available)
    with suppress(OSError, ValueError):  # no control groups of version 2, or none that is limited
        free = min(free, _of_group("memory.max") - _of_group("memory.current"))
    return free


def total_memory() -> float:
    """Memory [bytes] of the machine, or what the control group of this process may take of it."""
    total = float(psutil.virtual_memory().total)
    with suppress(OSError, ValueError):
        total = min(total, _of_group("memory.max"))
    return total


def _of_group(name: str) -> float:
    return float((_GROUP / name).read_text().strip())


MEMORY_OF_WORKER = 1e9  # bytes; docs/comparison.md has 1.1 GB for the largest of the reference rig's


def checked_workers(number: int) -> int:
    """raises: ValueError naming the option --jobs where it is below 1 or more than the memory holds"""
    if number < 1:
        raise ValueError(f"--jobs {number}: at least 1")
    if number > (most := max(int(total_memory() / MEMORY_OF_WORKER), 1)):
        raise ValueError(f"--jobs {number}: each takes about 1 GB of memory; at most {most} fit into this machine's")
    return number


def usual_workers() -> int:
    """The CPUs that this process may use, at most 4: each worker needs about 1 GB."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(usable, 4)
