"""One step of a branch: predicted along its tangent, corrected by Newton's method on the plane across it, and refused
where it has ended elsewhere than the branch goes (pseudo-arclength continuation, Keller 1977).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from updamp.hbm.continuation.branch import BranchPoint, point_after
from updamp.hbm.continuation.retracing import TracedBranch, on_same_branch, turn_between
from updamp.hbm.continuation.step_lengths import StepLengths
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Arc, NewtonOptions, Solution, Status, solve
from updamp.hbm.problem.system import Forcing, NonlinearSystem


@dataclass(frozen=True)
class StepOptions(StepLengths):
    """newton: of the corrector; patience: iterations after which a step longer than `short_step` is given up, unless
        the residual has fallen (`NewtonOptions.patience` holds for short ones): a long step that is given up too early
        costs a shorter one, a short one perhaps the branch
    persistent: of starts and of points far ahead, which have no smaller step to fall back on

    raises: ValueError naming the option that is out of range
    """

    newton: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=8, damped=False, patience=5))
    patience: int = 4
    persistent: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=20))


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
        arc = Arc(*self._predict(traced.points, step), last.tangent, last.metric)
        if step > self.options.short_step and newton.patience:
            newton = replace(newton, patience=self.options.patience)
        jacobian = last.solution.jacobian
        factors = None if jacobian is None else jacobian.factors
        solution = solve(self.system, self.excitation, arc.x0, arc.w0, newton, arc, factors)
        if not solution.converged:
            return None, solution
        point = point_after(last, solution, self.excitation)
        off = last.metric.length((solution.x - arc.x0, solution.w - arc.w0))
        if (
            self.options.counts(point.step, step)
            and (
                self.options.as_predicted(off, point.step)
                or self.options.one_turn(*turn_between(last, point), point.step)
            )
            and on_same_branch(last, point, traced.limits)
            and not traced.contains(point)
        ):
            return point, solution
        return None, replace(solution, status=Status.OFF_BRANCH)

    def _predict(self, points: Sequence[BranchPoint], step: float) -> Move:
        """Along the tangent, bent by the change of the tangent since the point before (second order)."""
        last = points[-1]
        x, w = last.x + step * last.tangent_x, last.w + step * last.tangent_w
        if len(points) < 2 or last.after_gap:
            return x, w
        before = points[-2]
        length = last.metric.length(before.tangent)
        if not self.options.bent(step, last.step, last.metric.product(before.tangent, last.tangent) / length):
            return x, w
        bend = step**2 / (2 * last.step)
        x = x + bend * (last.tangent_x - before.tangent_x / length)
        w = w + bend * (last.tangent_w - before.tangent_w / length)
        return x, w
