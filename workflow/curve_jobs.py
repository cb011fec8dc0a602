"""The curves of a run: each traced in a process of its own, one file a curve.

A curve that is interrupted is begun again. What continuation goes by is all that it has traced (no branch runs back
over itself), the last steps and their tangents: one that went on from its points alone would be another computation,
with other points and last digits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.analysis.adaptive import with_orders
from updamp.hbm.analysis.settings import more_harmonics, setting_of, with_setting
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.curve_records import observed_points
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem
from updamp.model.build import rig_model
from updamp.parallel.resources import Meter
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.job_pool import JobEnd, JobProgress


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
    memory_of: int | None = None,
) -> JobEnd:
    """Trace the job's curve and store it. Arguments as for `traced`."""
    return traced(job, report, should_stop, memory_of)[0]


def traced(
    job: CurveJob,
    report: Callable[[JobProgress], None] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
    memory_of: int | None = None,
) -> tuple[JobEnd, ResponseCurve]:
    """The job's curve, stored where it was not stopped; else as far as it came.

    should_stop: asked after every point; if true, nothing is stored
    memory_of: process whose memory (with all below it) is metered, this one by default
    """
    system, request = curve_problem(job)
    with Meter(memory_of) as meter:
        for curve in trace(system, request):
            report(_progress(curve, request.window, request.upwards))
            if not (curve.complete or curve.stopped) and should_stop():
                return JobEnd.INTERRUPTED, curve
    store.write(job.output, curve, store.Stamp(job.key, {"hbm": meter.seconds}, (meter.interval,), meter.peak_memory))
    return JobEnd.FINISHED, curve


def curve_problem(job: CurveJob) -> tuple[NonlinearSystem, CurveRequest]:
    """The nonlinear system and the request of a job, from the files of the stages before."""
    reduced, rest = store.read(job.finite_elements, ReducedModel, part="reduced"), store.read(job.rest, StaticContact)
    model = rig_model(reduced, rest, job.rig)
    setting = setting_of(model.system)
    setting = with_orders(setting, job.orders or setting.orders)
    setting = more_harmonics(setting) if job.finer else setting
    system = with_setting(model.system, setting) if setting != setting_of(model.system) else model.system
    window, points = job.rig.study.modes[job.mode].window, observed_points(system.free)
    told = (job.rig.response_point,)
    return system, CurveRequest(job.mode, model.excited_by(job.force), window, points, told=told)


def _progress(curve: ResponseCurve, window: tuple[float, float], upwards: bool) -> JobProgress:
    """The share counts how far the branch ever came: it turns back in frequency at folds."""
    low, high = window
    if not len(curve):  # none was found from this end of the window
        return JobProgress(0.0, "no point yet")
    reached = curve.frequency.max() - low if upwards else high - curve.frequency.min()
    share = min(max(float(reached) / (high - low), 0.0), 1.0)
    return JobProgress(share, f"{curve.frequency[-1]:.2f} Hz, {len(curve)} points")
