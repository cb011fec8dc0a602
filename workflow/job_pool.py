"""Jobs of a run shared over processes: each leaves one file, reports how far it is, and can be interrupted."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from queue import Empty
from typing import Any, Protocol

from updamp.hbm.compilation_cache import keep_compiled
from updamp.parallel.ending import DeafProcesses, Worker, end_children
from updamp.parallel.resources import checked_workers, environment, thread_limits
from updamp.parallel.workers import LOST

REPORT_EVERY = 0.2  # s


@dataclass(frozen=True)
class JobProgress:
    """share: of the work done so far, 0 to 1; detail: what is being done"""

    share: float
    detail: str


class JobEnd(Enum):
    """What became of a job."""

    FINISHED = "finished"  # also of a curve whose branch stopped early: the curve itself says so
    INTERRUPTED = "interrupted"
    FAILED = "failed"


class StoppedError(Exception):
    """The run was interrupted: what a job raises to get out of a computation."""


class Job(Protocol):
    """A piece of work that leaves one file."""

    @property
    def name(self) -> str: ...

    @property
    def output(self) -> Path: ...

    @property
    def key(self) -> str: ...

    @property
    def ease(self) -> tuple[float, ...]:
        """Smallest for the job that is begun first: the one expected to take longest."""
        ...

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """should_stop: asked now and then; if true, the job ends as soon as it can
        memory_of: process whose memory (with all below it) is metered
        """
        ...

    def conclusion(self) -> tuple[bool, str]:
        """Of what it left: whether that is whole, and a short line about it."""
        ...


@dataclass(frozen=True)
class JobOutcome:
    """end, and for a failure its sentence"""

    job: Job
    end: JobEnd
    message: str = ""


def run_all(
    jobs: Sequence[Job],
    workers: int,
    report: Callable[[Job, JobProgress], None],
    finished: Callable[[JobOutcome], None],
    following: Callable[[JobOutcome], Sequence[Job]] = lambda _: (),
) -> tuple[JobOutcome, ...]:
    """Run the jobs in `workers` processes; one that fails does not keep the others from being finished.

    report, finished: called in this process
    following: which further jobs can be begun now that one is over
    raises: KeyboardInterrupt after an interruption, once every worker has stored what it has solved; ValueError for
        more workers than the memory holds
    """
    checked_workers(workers)
    context = get_context("spawn")  # forking a process that has threads (MKL, JAX, VTK) can hang
    messages = context.Queue()
    alive, held = context.Pipe(duplex=False)  # closed, it asks the workers to end: no lock that a killed one could hold
    outcomes: list[JobOutcome] = []
    with (
        held,
        alive,
        environment(thread_limits(1)),
        DeafProcesses(workers, mp_context=context, initializer=_start_worker, initargs=(messages, alive)) as pool,
    ):
        try:  # from the first task on: leaving the context would wait for all of them
            begun = _Begun(pool)
            begun.add(jobs)
            for outcome in begun.outcomes(messages, report):
                outcomes.append(outcome)
                finished(outcome)
                begun.add(following(outcome))
        except BaseException:
            held.close()
            pool.shutdown(wait=False, cancel_futures=True)
            end_children()
            raise
    return tuple(outcomes)


class _Begun:
    """The jobs that a pool was handed, and what becomes of them. It changes as jobs are added and end."""

    def __init__(self, pool: ProcessPoolExecutor) -> None:
        self._pool = pool
        self._waiting: dict[Future[JobOutcome], Job] = {}
        self._by_output: dict[str, Job] = {}

    def add(self, jobs: Sequence[Job]) -> None:
        for job in sorted(jobs, key=lambda job: job.ease):
            self._by_output[str(job.output)] = job
            self._waiting[self._submitted(job)] = job

    def _submitted(self, job: Job) -> Future[JobOutcome]:
        try:
            return self._pool.submit(_work, job)
        except BrokenProcessPool as error:  # a worker was killed: as those that were handed in before
            lost: Future[JobOutcome] = Future()
            lost.set_exception(error)
            return lost

    def outcomes(self, messages: Any, report: Callable[[Job, JobProgress], None]) -> Iterator[JobOutcome]:
        """Each job's outcome as it comes, passing on progress in between; jobs may be added meanwhile."""
        while self._waiting:
            with suppress(Empty):
                output, progress = messages.get(timeout=REPORT_EVERY)
                report(self._by_output[output], progress)
            for future in [f for f in self._waiting if f.done()]:
                job = self._waiting.pop(future)
                error = future.exception()  # of the pool: a worker was killed
                yield future.result() if error is None else JobOutcome(job, JobEnd.FAILED, LOST)


_messages: Any = None
_worker: Worker | None = None


def _start_worker(messages: Any, alive: Connection) -> None:
    global _messages, _worker
    _worker = Worker(alive)
    keep_compiled()
    messages.cancel_join_thread()  # progress that nobody reads any more must not hold up the end
    _messages = messages


def _work(job: Job) -> JobOutcome:
    """Errors come back as text: not every exception survives the way between processes."""
    assert _worker is not None, "the pool has begun this process"
    last, asked = 0.0, _worker.asked.is_set

    def report(progress: JobProgress) -> None:
        nonlocal last
        if time.monotonic() - last > REPORT_EVERY:
            last = time.monotonic()
            _messages.put((str(job.output), progress))

    report(JobProgress(0.0, "loading and compiling"))
    try:
        return JobOutcome(job, job.run(report, asked, os.getppid()))
    except Exception as error:
        return JobOutcome(job, JobEnd.FAILED, _sentence(error))


def _sentence(error: Exception) -> str:
    """A ValueError says what is wrong with what was asked for; of others the kind is all that may be known."""
    return str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
