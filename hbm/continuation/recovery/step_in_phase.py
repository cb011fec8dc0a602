"""A point whose vibration is a little further in phase, at whatever frequency."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_after
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.recovery.switch_branch import lies_on_last_points
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.newton import Arc, solve


@dataclass(frozen=True)
class StepInPhase:
    """At resonance the phase goes on evenly where the frequency turns round in kinks that lie too close to each other
    for their far sides to be told apart.

    lengths: of the steps, in units of arc; moved: as in `StepLengths`, wider, since the frequency moves too
    """

    lengths: tuple[float, ...] = (1e-3, 3e-3, 0.01)
    moved: tuple[float, float] = (0.5, 3.0)

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        last, system, excitation = traced.last, corrector.system, corrector.excitation
        shift = system.harmonics.phase_derivative(last.x)
        size = last.metric.length((shift, 0.0))
        if not size:
            return []
        ahead = np.copysign(1 / size, last.metric.product((shift, 0.0), last.tangent))
        for step in self.lengths:
            plane = Arc(last.x + step * ahead * shift, last.w, (ahead * shift, 0.0), last.metric)
            solution = solve(system, excitation, plane.x0, plane.w0, corrector.options.newton, plane)
            if not solution.converged or lies_on_last_points(traced.points, solution):
                continue
            point = point_after(last, solution, excitation)
            least, most = self.moved
            if least * step < point.step < most * step and not traced.contains(point):
                return [point]
        return []
