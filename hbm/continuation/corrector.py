"""One step of a branch: predicted along its tangent, corrected by Newton's method on the plane across it, and refused
where it has ended elsewhere than the branch goes (pseudo-arclength continuation, Keller 1977).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_after
from updamp.hbm.continuation.retracing import TracedBranch, on_same_branch
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Arc, NewtonOptions, Solution, Status, solve
from updamp.hbm.problem.system import Forcing, NonlinearSystem


@dataclass(frozen=True)
class StepOptions:
    """Steps are lengths of arc in the relative metric (hbm/newton/metric.py).

    first_step, smallest_step, largest_step: the corrector's failures shorten the step down to the smallest
    short_step: steps up to this are shortened to a quarter, longer ones to a half: what stops short ones is a kink
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    newton: of the corrector; patience: iterations after which a step longer than `short_step` is given up, unless the
        residual has fallen (`NewtonOptions.patience` holds for short ones): a long step that is given up too early
        costs a shorter one, a short one perhaps the branch
    persistent: of starts and of points far ahead, which have no smaller step to fall back on

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-4
    largest_step: float = 0.2
    short_step: float = 0.01
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    newton: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=8, damped=False, patience=5))
    patience: int = 4
    persistent: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=20))

    def scale_w(self, window: tuple[float, float]) -> float:
        """Angular frequency that counts as one unit of arc [rad/s]; window [Hz]."""
        return 2 * np.pi * self.frequency_scale * (window[1] - window[0])

    def no_shorter(self, lengths: Sequence[float]) -> tuple[float, ...]:
        """The lengths, those below the smallest step raised to it, each once."""
        return tuple(dict.fromkeys(max(length, self.smallest_step) for length in lengths))

    def shortened(self, step: float) -> float:
        return max(step / (2 if step > max(self.short_step, self.smallest_step) else 4), self.smallest_step)

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step < self.first_step <= self.largest_step:
            raise ValueError(
                f"steps {self.smallest_step}, {self.first_step}, {self.largest_step}: "
                "0 < smallest_step < first_step <= largest_step is needed"
            )
        if self.frequency_scale <= 0:
            raise ValueError(f"frequency_scale = {self.frequency_scale}: it must be positive")


@dataclass(frozen=True, eq=False)
class Corrector:
    """Solves single steps; scale_w: one unit of arc [rad/s]"""

    system: NonlinearSystem
    excitation: Forcing
    options: StepOptions
    scale_w: float

    def step(
        self, traced: TracedBranch, step: float, newton: NewtonOptions | None = None
    ) -> tuple[BranchPoint | None, Solution]:
        """One step along the tangent and its corrector; no point where the corrector fails, or ends elsewhere than the
        branch goes.

        newton: of the corrector, by default that of the options
        """
        last, newton = traced.last, newton or self.options.newton
        arc = Arc(*_predict(traced.points, step), last.tangent, last.metric)
        if step > self.options.short_step and newton.patience:
            newton = replace(newton, patience=self.options.patience)
        jacobian = last.solution.jacobian
        factors = None if jacobian is None else jacobian.factors
        solution = solve(self.system, self.excitation, arc.x0, arc.w0, newton, arc, factors)
        if not solution.converged:
            return None, solution
        point = point_after(last, solution, self.excitation)
        near = 0.5 * step < point.step < 1.6 * step
        if near and on_same_branch(last, point, traced.limits) and not traced.contains(point):
            return point, solution
        return None, replace(solution, status=Status.STALLED)

    def next_step(self, point: BranchPoint, step: float) -> float:
        """The length to try after a point that a step of this length has led to."""
        growth = np.clip(2.0 ** ((self.options.wanted_iterations - point.solution.iterations) / 2), 0.5, 2.0)
        return float(np.clip(max(step, point.step) * growth, self.options.smallest_step, self.options.largest_step))


def _predict(points: Sequence[BranchPoint], step: float) -> Move:
    """Along the tangent, bent by the change of the tangent since the point before (second order)."""
    last = points[-1]
    x, w = last.x + step * last.tangent_x, last.w + step * last.tangent_w
    if len(points) > 1 and last.step > 0 and not last.after_gap:
        before = points[-2]
        bend, length = step**2 / (2 * last.step), last.metric.length(before.tangent)
        # across a kink, and far beyond what it was found from, the change of the tangent says nothing
        if step > 4 * last.step or last.metric.product(before.tangent, last.tangent) < 0.9 * length:
            return x, w
        x = x + bend * (last.tangent_x - before.tangent_x / length)
        w = w + bend * (last.tangent_w - before.tangent_w / length)
    return x, w
