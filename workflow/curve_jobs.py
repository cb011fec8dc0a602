"""The curves of a run: each traced in a process of its own, checkpointed, resumable.

A curve is one file. While it is being traced, what is solved so far stands in a partial file beside it, written
every few seconds; the next run with the same key goes on from there.
"""

import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from multiprocessing import get_context
from pathlib import Path
from queue import Empty
from typing import Any

import numpy as np

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.analysis.settings import more_harmonics, setting_of, with_setting
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem
from updamp.model.build import rig_model
from updamp.parallel.resources import Meter, environment, thread_limits
from updamp.rig.rig import Rig
from updamp.workflow import store

CHECKPOINT_EVERY = 20.0  # s
REPORT_EVERY = 0.2  # s


@dataclass(frozen=True)
class CurveJob:
    """One curve to trace.

    force: amplitude [N]; key: of the curve; finite_elements, rest: files of the stages before; output: the curve's file
    finer: whether it is traced with more harmonics, to see what they change
    """

    rig: Rig
    mode: str
    force: float
    key: str
    finite_elements: Path
    rest: Path
    output: Path
    finer: bool = False

    @property
    def name(self) -> str:
        return f"{self.mode} {self.force:g} N{', more harmonics' if self.finer else ''}"

    @property
    def partial(self) -> Path:
        return self.output.with_suffix(".partial.h5")


@dataclass(frozen=True)
class CurveProgress:
    """share: of the window covered so far, 0 to 1; frequency [Hz]; points solved"""

    share: float
    frequency: float
    points: int


class CurveEnd(Enum):
    """What became of a curve."""

    FINISHED = "finished"  # also where the branch stopped early: the curve itself says so
    INTERRUPTED = "interrupted"
    FAILED = "failed"


@dataclass(frozen=True)
class CurveOutcome:
    """end, and for a failure its sentence"""

    job: CurveJob
    end: CurveEnd
    message: str = ""


def trace_curve(
    job: CurveJob,
    report: Callable[[CurveProgress], None] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
    checkpoint_every: float = CHECKPOINT_EVERY,
    memory_of: int | None = None,
) -> CurveEnd:
    """Trace the job's curve, from its partial file on if that fits, and store it.

    should_stop: asked after every point; if true, what is solved is kept in the partial file
    checkpoint_every: [s]
    memory_of: process whose memory (with all below it) is metered, this one by default
    """
    system, request = curve_problem(job)
    earlier, stamp = _resumable(job)
    last_written, curve = -np.inf, earlier
    with Meter(memory_of) as meter:
        for curve in trace(system, request, earlier):
            report(_progress(curve, request.window, request.upwards))
            if curve.complete or curve.stopped:
                break
            stop = should_stop()
            if stop or time.monotonic() - last_written > checkpoint_every:
                store.write(job.partial, curve, _stamp(job, stamp, meter))
                last_written = time.monotonic()
            if stop:
                return CurveEnd.INTERRUPTED
    assert curve is not None, "a trace hands out at least one curve"
    store.write(job.output, curve, _stamp(job, stamp, meter))
    job.partial.unlink(missing_ok=True)
    return CurveEnd.FINISHED


def curve_problem(job: CurveJob) -> tuple[NonlinearSystem, CurveRequest]:
    """The nonlinear system and the request of a job, from the files of the stages before."""
    reduced, rest = store.read(job.finite_elements, ReducedModel, part="reduced"), store.read(job.rest, StaticContact)
    model = rig_model(reduced, rest, job.rig)
    system = with_setting(model.system, more_harmonics(setting_of(model.system))) if job.finer else model.system
    observed = tuple(name for name in system.free.points if ".excitation." not in name)
    window = job.rig.study.modes[job.mode].window
    return system, CurveRequest(job.mode, model.excited_by(job.force), window, observed)


def _resumable(job: CurveJob) -> tuple[ResponseCurve | None, store.Stamp]:
    fresh = store.Stamp(job.key)
    try:
        stamp = store.read_stamp(job.partial)
        return (store.read(job.partial, ResponseCurve), stamp) if stamp.key == job.key else (None, fresh)
    except store.StoreError:  # none there, or one that was damaged: from the start then
        return None, fresh


def _stamp(job: CurveJob, earlier: store.Stamp, meter: Meter) -> store.Stamp:
    intervals = (*earlier.intervals, meter.interval)
    seconds = sum(end - start for start, end in intervals)
    return store.Stamp(job.key, {"hbm": seconds}, intervals, max(earlier.peak_memory, meter.peak_memory))


def _progress(curve: ResponseCurve, window: tuple[float, float], upwards: bool) -> CurveProgress:
    """The share counts how far the branch ever came: it turns back in frequency at folds."""
    low, high = window
    if not len(curve):  # none was found from this end of the window
        return CurveProgress(0.0, low if upwards else high, 0)
    reached = curve.frequency.max() - low if upwards else high - curve.frequency.min()
    share = min(max(float(reached) / (high - low), 0.0), 1.0)
    return CurveProgress(share, float(curve.frequency[-1]), len(curve))


# --- many curves at once ---


def trace_all(
    jobs: Sequence[CurveJob],
    workers: int,
    report: Callable[[CurveJob, CurveProgress], None],
    finished: Callable[[CurveOutcome], None],
) -> tuple[CurveOutcome, ...]:
    """Trace the curves in `workers` processes; one that fails does not keep the others from being finished.

    report, finished: called in this process
    raises: KeyboardInterrupt after an interruption, once every worker has stored what it has solved
    """
    context = get_context("spawn")  # forking a process that has threads (MKL, JAX, VTK) can hang
    messages, stop = context.Queue(), context.Event()
    by_output = {str(job.output): job for job in jobs}
    outcomes: list[CurveOutcome] = []
    with (
        environment(thread_limits(1)),
        ProcessPoolExecutor(workers, mp_context=context, initializer=_start_worker, initargs=(messages, stop)) as pool,
    ):
        futures = {pool.submit(_work, job): job for job in sorted(jobs, key=_ease)}
        try:
            for outcome in _outcomes(futures, messages, lambda name, progress: report(by_output[name], progress)):
                outcomes.append(outcome)
                finished(outcome)
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return tuple(outcomes)


def _ease(job: CurveJob) -> tuple[float, float]:
    """Smallest for the curve that is started first: the one expected to take longest, so that none is left over at
    the end. A large force makes more contacts slip and open, and in a wide window the branch is longer.
    """
    low, high = job.rig.study.modes[job.mode].window
    return -job.force, low - high


def _outcomes(
    futures: Mapping[Future[CurveOutcome], CurveJob], messages: Any, report: Callable[[str, CurveProgress], None]
) -> Iterator[CurveOutcome]:
    """Each curve's outcome as it comes, passing on progress in between."""
    waiting = dict(futures)
    while waiting:
        with suppress(Empty):
            report(*messages.get(timeout=REPORT_EVERY))
        for future in [f for f in waiting if f.done()]:
            job = waiting.pop(future)
            error = future.exception()  # of the pool, such as a worker that the system has killed for want of memory
            yield future.result() if error is None else CurveOutcome(job, CurveEnd.FAILED, f"{error}")


_messages: Any = None
_stop: Any = None


def _start_worker(messages: Any, stop: Any) -> None:
    """An interruption from the keyboard reaches the workers too; the parent asks them to stop."""
    global _messages, _stop
    keep_compiled()
    messages.cancel_join_thread()  # progress that nobody reads any more must not hold up the end
    _messages, _stop = messages, stop
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(job: CurveJob) -> CurveOutcome:
    """Errors come back as text: not every exception survives the way between processes."""
    last, parent = 0.0, os.getppid()

    def report(progress: CurveProgress) -> None:
        nonlocal last
        if time.monotonic() - last > REPORT_EVERY:
            last = time.monotonic()
            _messages.put((str(job.output), progress))

    def orphaned() -> bool:
        return os.getppid() != parent

    try:
        outcome = CurveOutcome(job, trace_curve(job, report, lambda: _stop.is_set() or orphaned(), memory_of=parent))
    except Exception as error:
        outcome = CurveOutcome(job, CurveEnd.FAILED, f"{type(error).__name__}: {error}")
    if orphaned():
        os._exit(1)  # the pool is gone, and its queues would be waited for without end
    return outcome
