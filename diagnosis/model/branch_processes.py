"""Branches predicted by several processes, each with one thread.

The model goes over with every task: 0.3 MB with 36 contacts, some MB with 146, which is milliseconds beside the
seconds of a branch. Branches come back without matrices (`light_points.py`).
"""

import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection

from updamp.diagnosis.model.branch_tasks import BranchTask, PredictionError, Report, in_turn
from updamp.diagnosis.model.predicted_branch import PredictedBranch
from updamp.hbm.compilation_cache import keep_compiled, keeps_compiled
from updamp.resources import environment, thread_limits


@dataclass(frozen=True)
class ByProcesses:
    """pool: of workers that `_begin` has prepared; report: called in this process"""

    pool: ProcessPoolExecutor
    report: Report = in_turn.report

    def __call__(self, tasks: Sequence[BranchTask]) -> tuple[PredictedBranch, ...]:
        """raises: as `BranchTask.predicted`; PredictionError where a worker was ended from outside"""
        # those that take longest first, or one worker would be busy with them alone in the end
        order = sorted(range(len(tasks)), key=lambda i: -tasks[i].effort)
        futures = {self.pool.submit(tasks[i].predicted): i for i in order}
        found: dict[int, PredictedBranch] = {}
        try:
            for future in as_completed(futures):
                place = futures[future]
                found[place] = _result(future, tasks[place])
                self.report(tasks[place].condition.name, len(found), len(tasks))
        finally:
            for future in futures:
                future.cancel()
        return tuple(found[i] for i in range(len(tasks)))


def _result(future: "Future[PredictedBranch]", task: BranchTask) -> PredictedBranch:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise PredictionError(
            f"{task.condition.name}: a process that traces branches was ended from outside, likely for want of memory; "
            "run again with fewer --jobs"
        ) from error


@contextmanager
def by_processes(workers: int, report: Report = in_turn.report) -> Iterator[ByProcesses]:
    """Workers for as long as the context lasts. They start with the first task, and end at once where the context is
    left by an error or an interruption, or this process is gone."""
    context = get_context("spawn")  # forking a process that has threads (MKL, JAX) can hang
    alive, held = context.Pipe(duplex=False)
    with held, alive, environment(thread_limits(1)):
        pool = ProcessPoolExecutor(workers, context, _begin, (alive, keeps_compiled()))
        try:
            yield ByProcesses(pool, report)
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
