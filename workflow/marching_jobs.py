"""Whether the motion at a traced curve's peak stays when it is marched in time, as a job of its own."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.time_marching.marched_peak import MarchedPeak, marched_peak
from updamp.parallel.resources import Meter
from updamp.workflow import store
from updamp.workflow.about_curve import JobAboutCurve
from updamp.workflow.curve_jobs import curve_problem
from updamp.workflow.job_pool import JobEnd, JobProgress, StoppedError


@dataclass(frozen=True)
class MarchingJob(JobAboutCurve):
    """Of the curve that `curve` leaves: whether the motion at its peak stays."""

    kind: ClassVar = MarchedPeak
    about: ClassVar = "marched in time"
    part: ClassVar = "marching"

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """An interruption loses this peak's march.

        raises: StoreError where the files of the stages before cannot be read
        """

        def after_a_period(share: float) -> None:
            report(JobProgress(share, "marched in time"))
            if should_stop():
                raise StoppedError

        with Meter(memory_of) as meter:
            (system, request), curve = curve_problem(self.curve), store.read(self.curve.output, ResponseCurve)
            try:
                found = marched_peak(system, request.excitation, curve, self.point, report=after_a_period)
            except StoppedError:
                return JobEnd.INTERRUPTED
        self.keep(found, meter)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        found = store.read(self.output, MarchedPeak)
        return True, f"{found.sentence}, {found.seconds:.1f} s"
