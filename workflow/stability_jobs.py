"""The stability of a traced curve, as a job of its own: the curve is not traced again for it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability, State, branch_stability
from updamp.parallel.resources import Meter
from updamp.workflow import store
from updamp.workflow.about_curve import JobAboutCurve
from updamp.workflow.curve_jobs import curve_problem
from updamp.workflow.job_pool import JobEnd, JobProgress, StoppedError

SPOKEN = (State.STABLE, State.UNSTABLE, State.UNKNOWN)


@dataclass(frozen=True)
class StabilityJob(JobAboutCurve):
    """Of the curve that `curve` leaves: whether its points are stable."""

    kind: ClassVar = BranchStability
    about: ClassVar = "stability"
    part: ClassVar = "stability"

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """Compute and store it. Points that cannot be computed are unknown; an interruption loses this curve's.

        raises: StoreError where the files of the stages before cannot be read
        """

        def at(share: float) -> None:
            report(JobProgress(share, "stability"))
            if should_stop():
                raise StoppedError

        with Meter(memory_of) as meter:
            system, _ = curve_problem(self.curve)
            try:
                found = branch_stability(system, store.read(self.curve.output, ResponseCurve), self.point, report=at)
            except StoppedError:
                return JobEnd.INTERRUPTED
        self.keep(found, meter)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        found = store.read(self.output, BranchStability)
        shares = ", ".join(f"{found.share(state):.0%} {state.name.lower()}" for state in SPOKEN)
        return True, f"{shares}, {found.seconds:.1f} s"
