"""The resonance of a mode followed in the force, as a job: its peak against force, without the curves."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.resonance_curve import ResonanceCurve, ResonanceRequest, trace_resonance
from updamp.model.build import rig_model
from updamp.parallel.resources import Meter
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.job_pool import JobEnd, JobProgress

BEFORE_FIRST = 0.01  # of the lowest force: where following begins, all but linear


@dataclass(frozen=True)
class ResonanceJob:
    """point: whose first harmonic is largest at the resonance; key: of the resonance; output: its file
    finite_elements, rest: files of the stages before"""

    rig: Rig
    mode: str
    point: str
    key: str
    finite_elements: Path
    rest: Path
    output: Path
    kind: ClassVar = ResonanceCurve

    @property
    def name(self) -> str:
        return f"{self.mode}, resonance"

    @property
    def ease(self) -> tuple[float, ...]:
        """Takes as long as the curve at the highest force."""
        low, high = self.rig.study.modes[self.mode].window
        return 0.0, -max(self.rig.study.force_levels), low - high

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """Follow and store it. What stops on the way is stored with its sentence; an interruption loses it.

        raises: StoreError where the files of the stages before cannot be read; ValueError where the mode's window has
            no mode
        """
        forces = sorted(self.rig.study.force_levels)
        with Meter(memory_of) as meter:
            reduced, rest = store.read(self.finite_elements, ReducedModel, part="reduced"), self._rest()
            model = rig_model(reduced, rest, self.rig)
            window = self.rig.study.modes[self.mode].window
            levels = (BEFORE_FIRST * forces[0], *forces)
            request = ResonanceRequest(self.mode, model.excitation, self.point, window, levels, MaximumResonance())
            for found in trace_resonance(model.system, request):
                if len(found):
                    share = float((found.force >= forces[0]).sum() > 0) * min(found.force[-1] / forces[-1], 1.0)
                    report(JobProgress(share, f"{found.force[-1]:.4g} N, {found.frequency[-1]:.2f} Hz"))
                if should_stop():
                    return JobEnd.INTERRUPTED
        stamp = store.Stamp(self.key, {"resonance": meter.seconds}, (meter.interval,), meter.peak_memory)
        store.write(self.output, found, stamp)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        found = store.read(self.output, ResonanceCurve)
        return found.complete, found.stopped or f"{len(found)} points, {found.seconds:.1f} s"

    def _rest(self) -> StaticContact:
        return store.read(self.rest, StaticContact)
