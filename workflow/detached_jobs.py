"""Branches beside a traced curve, as a job: those that the resonance followed in force has come to, too."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from updamp.hbm.continuation.detached import Place, missing
from updamp.hbm.continuation.predictor_corrector import ContinuationOptions
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.detached_branches import DetachedBranches, detached_branches
from updamp.parallel.resources import Meter
from updamp.workflow import store
from updamp.workflow.about_curve import JobAboutCurve
from updamp.workflow.curve_jobs import curve_problem
from updamp.workflow.job_pool import JobEnd, JobProgress


@dataclass(frozen=True)
class DetachedJob(JobAboutCurve):
    """Of the curve that `curve` leaves: branches beside it.

    resonance: file of the mode's resonance, None where it was not followed
    """

    resonance: Path | None
    kind: ClassVar = DetachedBranches
    about: ClassVar = "detached branches"
    part: ClassVar = "detached"

    def run(
        self, report: Callable[[JobProgress], None], should_stop: Callable[[], bool], memory_of: int | None
    ) -> JobEnd:
        """raises: StoreError where the files of the stages before cannot be read"""
        if should_stop():
            return JobEnd.INTERRUPTED
        report(JobProgress(0.0, "branches beside the curve"))
        with Meter(memory_of) as meter:
            (system, request), curve = curve_problem(self.curve), store.read(self.curve.output, ResponseCurve)
            followed = store.read(self.resonance, ResonanceCurve) if self.resonance is not None else None
            places = resonances_at(curve, followed) if followed is not None else []
            found = detached_branches(system, request, curve, self.point, places)
        self.keep(found, meter)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        found = store.read(self.output, DetachedBranches)
        return True, f"{len(found.branches)} found, {found.seconds:.1f} s"


def resonances_at(curve: ResponseCurve, followed: ResonanceCurve) -> list[Place]:
    """The resonances at the curve's force, each time that it was passed, in the curve's harmonics."""
    at = followed.passes(curve.force)
    harmonics = Harmonics(followed.orders)
    x = [harmonics.change_to(curve.harmonics, followed.displacement[i]) for i in at]
    return [(one, 2 * np.pi * float(followed.frequency[i])) for one, i in zip(x, at, strict=True)]


def has_more(curve: ResponseCurve, followed: ResonanceCurve | None, window: tuple[float, float]) -> bool:
    """Whether there is anything beside the curve to be looked at."""
    places = resonances_at(curve, followed) if followed is not None else []
    return bool(curve.detached or missing(curve, places, ContinuationOptions().scale_w(window)))
