"""The curves of a run: each traced in a process of its own, checkpointed, resumable.

A curve is one file. While it is being traced, what is solved so far stands in a partial file beside it, written
every few seconds; the next run with the same key goes on from there.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.analysis.adaptive import with_orders
from updamp.hbm.analysis.settings import more_harmonics, setting_of, with_setting
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem
from updamp.model.build import rig_model
from updamp.parallel.resources import Meter
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.job_pool import JobEnd, JobProgress

CHECKPOINT_EVERY = 20.0  # s


@dataclass(frozen=True)
class CurveJob:
    """One curve to trace.

    force: amplitude [N]; key: of the curve; finite_elements, rest: files of the stages before; output: the curve's file
    finer: whether it is traced with more harmonics, to see what they change
    orders: harmonics, those of the rig file where there are none here; a finer one's are continued from these
    """

    rig: Rig
    mode: str
    force: float
    key: str
    finite_elements: Path
    rest: Path
    output: Path
    finer: bool = False
    orders: tuple[int, ...] = ()
    kind: ClassVar = ResponseCurve

    @property
    def name(self) -> str:
        return f"{self.mode} {self.force:g} N{', more harmonics' if self.finer else ''}"

    @property
    def partial(self) -> Path:
        return self.output.with_suffix(".partial.h5")

    @property
    def ease(self) -> tuple[float, ...]:
        """A large force makes more contacts slip and open, and in a wide window the branch is longer. The curves
        themselves come before the finer ones.
        """
        low, high = self.rig.study.modes[self.mode].window
        return float(self.finer), -self.force, low - high

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        return trace_curve(self, report, should_stop, memory_of=memory_of)

    def conclusion(self) -> tuple[bool, str]:
        curve = store.read(self.output, ResponseCurve)
        return not curve.stopped, curve.stopped or f"{len(curve)} points, {curve.seconds:.1f} s"


def trace_curve(
    job: CurveJob,
    report: Callable[[JobProgress], None] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
    checkpoint_every: float = CHECKPOINT_EVERY,
    memory_of: int | None = None,
) -> JobEnd:
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
                return JobEnd.INTERRUPTED
    assert curve is not None, "a trace hands out at least one curve"
    store.write(job.output, curve, _stamp(job, stamp, meter))
    job.partial.unlink(missing_ok=True)
    return JobEnd.FINISHED


def curve_problem(job: CurveJob) -> tuple[NonlinearSystem, CurveRequest]:
    """The nonlinear system and the request of a job, from the files of the stages before."""
    reduced, rest = store.read(job.finite_elements, ReducedModel, part="reduced"), store.read(job.rest, StaticContact)
    model = rig_model(reduced, rest, job.rig)
    setting = setting_of(model.system)
    setting = with_orders(setting, job.orders or setting.orders)
    setting = more_harmonics(setting) if job.finer else setting
    system = with_setting(model.system, setting) if setting != setting_of(model.system) else model.system
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


def _progress(curve: ResponseCurve, window: tuple[float, float], upwards: bool) -> JobProgress:
    """The share counts how far the branch ever came: it turns back in frequency at folds."""
    low, high = window
    if not len(curve):  # none was found from this end of the window
        return JobProgress(0.0, "no point yet")
    reached = curve.frequency.max() - low if upwards else high - curve.frequency.min()
    share = min(max(float(reached) / (high - low), 0.0), 1.0)
    return JobProgress(share, f"{curve.frequency[-1]:.2f} Hz, {len(curve)} points")
