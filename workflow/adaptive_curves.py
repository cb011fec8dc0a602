"""A curve of a rig file with harmonics = "auto": a file for each set, so that an interruption loses none."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from updamp.hbm.analysis.adaptive import adaptive
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.rig.rig import FIRST_HARMONICS
from updamp.workflow import store
from updamp.workflow.curve_jobs import CurveJob, trace_curve
from updamp.workflow.job_pool import JobEnd, JobProgress


@dataclass(frozen=True)
class ChosenHarmonics:
    """Of one curve. orders: used; tried: the highest ones in turn; status: whether the tolerance is met, in words"""

    mode: str
    force: float
    orders: tuple[int, ...]
    tried: tuple[int, ...]
    status: str


def chosen_file(curve: Path) -> Path:
    return curve.with_name(f"{curve.stem}_chosen.h5")


@dataclass(frozen=True)
class AdaptiveCurveJob(CurveJob):
    """A curve whose harmonics are chosen. point: where the peak is taken; tolerance: of the peak, as a share of it"""

    point: str = ""
    tolerance: float = 0.01

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """The curve's own stamp has what all the tried ones cost."""
        stamps: list[store.Stamp] = []

        def traced_with(orders: tuple[int, ...]) -> ResponseCurve | None:
            job = self.with_harmonics(orders)
            there = _is_there(job)
            if not there and trace_curve(job, report, should_stop, memory_of=memory_of) is not JobEnd.FINISHED:
                return None
            stamps.append(store.read_stamp(job.output))
            return store.read(job.output, ResponseCurve)

        found = adaptive(traced_with, FIRST_HARMONICS, self.point, self.tolerance)
        if found.curve is None or found.status is None:
            return JobEnd.INTERRUPTED
        intervals = tuple(interval for stamp in stamps for interval in stamp.intervals)
        seconds = {"hbm": sum(stamp.seconds.get("hbm", 0.0) for stamp in stamps)}
        peak = max(stamp.peak_memory for stamp in stamps)
        stamp = store.Stamp(self.key, seconds, intervals, peak)
        tried = tuple(orders[-1] for orders in found.tried)
        chosen = ChosenHarmonics(self.mode, self.force, found.curve.orders, tried, found.status.value)
        store.write(chosen_file(self.output), chosen, stamp)
        store.write(self.output, found.curve, stamp)
        return JobEnd.FINISHED

    def with_harmonics(self, orders: tuple[int, ...]) -> CurveJob:
        """The same curve with given harmonics, in a file of its own."""
        output = self.output.with_name(f"{self.output.stem}_harmonics{orders[-1]}.h5")
        key = f"{self.key} {','.join(map(str, orders))}"
        return CurveJob(self.rig, self.mode, self.force, key, self.finite_elements, self.rest, output, orders=orders)

    def conclusion(self) -> tuple[bool, str]:
        well, sentence = super().conclusion()
        orders = store.read(self.output, ResponseCurve).orders
        return well, f"{sentence}, harmonics up to {orders[-1]}"


def of_these_harmonics(job: CurveJob, curve: ResponseCurve) -> CurveJob:
    """The job with the harmonics that the curve has; those of a finer one are continued from these."""
    return replace(job, orders=curve.orders)


def _is_there(job: CurveJob) -> bool:
    try:
        return store.read_stamp(job.output).key == job.key
    except store.StoreError:
        return False
