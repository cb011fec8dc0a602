"""A point of the rig's harmonic balance against the periodic motion that marching in time gives.

Structural damping is replaced by viscous damping that is equal to it at one frequency, in both. Both motions are taken
on one plane across the branch: at a fixed frequency on a steep flank the difference would be that of the flank.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from updamp.benchmarks.time_integration.shooting import Periodic, Plane, shoot
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.static_contact import static_contact
from updamp.hbm.analysis.accuracy import solve_again
from updamp.hbm.analysis.settings import Setting, with_setting
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.continuation.curve import CurveRequest
from updamp.hbm.newton import observe
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.observe import contact_states
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.time_marching.march import March
from updamp.model.build import rig_model
from updamp.rig.rig import Rig

TIP = "blade_right.tip.x"
FINER = Setting((0, 1, 2, 3, 4, 5, 6, 7), 256, 3)


class MarchedCase(NamedTuple):
    """A curve. loss: factor at the middle of the window, None for the rig's; window [Hz]; force [N]"""

    mode: str
    force: float
    window: tuple[float, float]
    loss: float | None = None


class Difference(NamedTuple):
    """Of a point less the marched motion. percent: of the amplitude; hertz; widths: both, in half-widths of a
    resonance of the case's loss factor, for which amplitude and frequency count alike."""

    percent: float
    hertz: float
    widths: float


@dataclass(frozen=True, eq=False)
class Problem:
    system: NonlinearSystem
    request: CurveRequest
    loss: float

    @staticmethod
    def of(reduced: ReducedModel, rig: Rig, case: MarchedCase) -> "Problem":
        """The rig with viscous damping in place of the structural one."""
        model = rig_model(reduced, static_contact(reduced, rig), rig)
        system = model.system
        loss = rig.material.loss_factor if case.loss is None else case.loss
        equivalent = loss / rig.material.loss_factor * system.free.hysteretic / (2 * np.pi * np.mean(case.window))
        free = replace(system.free, hysteretic=0 * system.free.hysteretic, viscous=equivalent)
        system = replace(system, free=free)
        return Problem(system, CurveRequest(case.mode, model.excited_by(case.force), case.window, (TIP,)), loss)

    @property
    def row(self) -> int:
        return self.system.free.row(TIP)

    def branch(self) -> list[BranchPoint]:
        """Of the harmonic balance, as far as it goes through the window."""
        request = self.request
        return list(continue_branch(self.system, request.excitation, request.window, request.options))

    def amplitude(self, point: BranchPoint) -> complex:
        return self._amplitude(point.solution.equation)

    def _amplitude(self, equation: Any) -> complex:
        response = observe.response(equation, self.request.excitation, np.array([self.row]))
        return complex(equation.receptance.system.harmonics.amplitude(response[0], 1))

    def states(self, point: BranchPoint) -> np.ndarray:
        """Number of contacts that stick, slip, separate, never touch."""
        return np.bincount(contact_states(self.system, point.x, point.w), minlength=4)

    def finer(self, point: BranchPoint, setting: Setting = FINER) -> BranchPoint | None:
        return solve_again(self.request, point, with_setting(self.system, setting))

    def march(self, point: BranchPoint, near: BranchPoint | None = None, steps: int = 1024) -> Periodic:
        """On the plane across the branch at `point`, started from `near` (a finer solution there)."""
        start = near or point
        march = March.of(self.system, self.request.excitation, self.row, start.w, steps)
        state = march.start(start.solution.equation.receptance.system, start.x)
        return shoot(march, state, self._plane(point))

    def difference(self, point: BranchPoint, marched: Periodic) -> Difference:
        share = abs(self.amplitude(point)) / abs(marched.amplitude) - 1
        shift = (point.w - marched.w) / marched.w
        return Difference(100 * share, point.frequency * shift, float(np.hypot(share, 2 * shift / self.loss)))

    def apart(self, one: Periodic, other: Periodic) -> float:
        """Two marched motions on one plane, in half-widths as in Difference."""
        share = abs(one.amplitude) / abs(other.amplitude) - 1
        return float(np.hypot(share, 2 * (one.w / other.w - 1) / self.loss))

    def change(self, point: BranchPoint, finer: BranchPoint) -> float:
        """From one setting to another, in half-widths as in Difference: the error estimate of
        hbm/analysis/accuracy.py."""
        share = abs(self.amplitude(finer)) / abs(self.amplitude(point)) - 1
        return float(np.hypot(share, 2 * (finer.w / point.w - 1) / self.loss))

    def _plane(self, point: BranchPoint) -> Plane:
        small = 1e-5 * point.metric.length((point.x, 0.0))
        ahead = evaluate(
            self.system, self.request.excitation, point.x + small * point.tangent_x, point.w + small * point.tangent_w
        )
        X = self.amplitude(point)
        rate = point.tangent_w * point.w / point.metric.scale_w**2
        return Plane(X, point.w, (self._amplitude(ahead) - X) / small, rate)
