"""What finer samples and cycles change in a traced curve, as a job of its own."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from updamp.hbm.analysis.finer_points import PointErrors, point_errors
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.parallel.resources import Meter
from updamp.workflow import store
from updamp.workflow.about_curve import JobAboutCurve
from updamp.workflow.curve_jobs import curve_problem
from updamp.workflow.job_pool import JobEnd, JobProgress


@dataclass(frozen=True)
class AccuracyJob(JobAboutCurve):
    """Of the curve that `curve` leaves: errors at its peak and beside it."""

    kind: ClassVar = PointErrors
    about: ClassVar = "samples and cycles"
    part: ClassVar = "accuracy"

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """raises: StoreError where the files of the stages before cannot be read"""
        if should_stop():
            return JobEnd.INTERRUPTED
        report(JobProgress(0.0, "peak and flanks"))
        with Meter(memory_of) as meter:
            system, request = curve_problem(self.curve)
            found = point_errors(system, request, store.read(self.curve.output, ResponseCurve), self.point)
        self.keep(found, meter)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        found = store.read(self.output, PointErrors)
        return True, found.reason or f"peak {found.samples[0]:+.2g} % and {found.cycles[0]:+.2g} %"
