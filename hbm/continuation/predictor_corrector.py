"""Predictor and corrector: how the points of one branch follow each other, and what is tried where a step fails.

Pseudo-arclength continuation (Keller 1977): a step along the tangent, bent by the tangent's last change, then Newton's
method on the plane across it. A corrector that fails shortens the step. Where no shorter step helps, the recoveries
follow in turn: a supported tangent of the mean position, branch switching at a kink, a point a little ahead, one a
little further in phase, branch switching with the orientation reversed, a jump.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_after
from updamp.hbm.continuation.branch_switching import BranchDirection, directions_beyond_kink, lies_on_last_points
from updamp.hbm.continuation.jump import back_to_gap, point_beyond_gap
from updamp.hbm.continuation.retracing import TracedBranch, on_same_branch
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Arc, NewtonOptions, Solution, Status, solve
from updamp.hbm.problem.system import Forcing, NonlinearSystem

# Steps below this are shortened faster, where the options allow them at all: what stops them is a kink.
_SHORT = 0.01
# Iterations after which a longer step is given up unless the residual has fallen.
_LESS_PATIENCE = 4


@dataclass(frozen=True)
class ContinuationOptions:
    """Steps are lengths of arc in the relative metric (hbm/newton/metric.py).

    first_step, smallest_step, largest_step: the corrector's failures shorten the step down to the smallest
    skips, jumps: where no smaller step helps and branch switching does not, points so far ahead are tried, no nearer
        than the smallest step
    phase_steps: likewise, of a step in phase [rad]
    supports, supported_steps: before that, steps with so much of the contacts' stiffness kept in Newton's tangent of
        the mean position (`NewtonOptions.support`)
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    outside: where no first point is found at the end of the window, so far beyond it, in shares of its width;
        negative: so far inside it
    max_points: at most this many points a branch
    newton: of the corrector; persistent: of a jump, which has no smaller step to fall back on

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-4
    largest_step: float = 0.2
    skips: tuple[float, ...] = (3e-4, 1e-3, 3e-3, 0.01)
    phase_steps: tuple[float, ...] = (1e-3, 3e-3, 0.01)
    supports: tuple[float, ...] = (0.0, 1e-5, 1e-3)
    supported_steps: tuple[float, ...] = (0.01, 1e-3, 1e-4)
    jumps: tuple[float, ...] = (0.03, 0.1, 0.2, 0.4)
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    outside: tuple[float, ...] = (-0.01, -0.04, 0.1, 0.3)
    max_points: int = 2000
    newton: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=8, damped=False, patience=5))
    persistent: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=20))

    def scale_w(self, window: tuple[float, float]) -> float:
        """Angular frequency that counts as one unit of arc [rad/s]; window [Hz]."""
        return 2 * np.pi * self.frequency_scale * (window[1] - window[0])

    @property
    def short_step(self) -> float:
        """Up to which a step counts as short."""
        return max(_SHORT, self.smallest_step)

    def no_shorter(self, lengths: Sequence[float]) -> tuple[float, ...]:
        """The lengths, those below the smallest step raised to it, each once."""
        return tuple(dict.fromkeys(max(length, self.smallest_step) for length in lengths))

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step < self.first_step <= self.largest_step:
            raise ValueError(
                f"steps {self.smallest_step}, {self.first_step}, {self.largest_step}: "
                "0 < smallest_step < first_step <= largest_step is needed"
            )
        if self.frequency_scale <= 0 or self.max_points < 2:
            raise ValueError("frequency_scale must be positive and max_points at least 2")
        if not all(0 <= support < 1 for support in self.supports):
            raise ValueError(f"supports = {self.supports}: each at least 0 and below 1")


class BranchStoppedError(RuntimeError):
    """A branch that cannot go on. What was computed has been handed out already.

    whose: name of the branch, where the message is to say it
    """

    def __init__(self, frequency: float, error: float, status: Status, whose: str = "") -> None:
        self.frequency, self.error, self.status, self.whose = frequency, error, status, whose
        super().__init__(
            f"{whose}{': ' if whose else ''}the branch stops at {frequency:.4f} Hz: {status.value}, residual "
            f"{error:.1e} of the displacement; {status.advice}"
        )

    def of(self, whose: str) -> "BranchStoppedError":
        return BranchStoppedError(self.frequency, self.error, self.status, whose)

    def __reduce__(self) -> tuple[type["BranchStoppedError"], tuple[float, float, Status, str]]:
        return BranchStoppedError, (self.frequency, self.error, self.status, self.whose)


@dataclass(frozen=True, eq=False)
class PredictorCorrector:
    """Finds the next points of a branch from those traced so far; scale_w: one unit of arc [rad/s]"""

    system: NonlinearSystem
    excitation: Forcing
    options: ContinuationOptions
    scale_w: float

    def next_points(self, traced: TracedBranch, step: float) -> tuple[Sequence[BranchPoint], float]:
        """The next point, or those beyond a jump, and the step to try after them.

        raises: BranchStoppedError
        """
        options, last = self.options, traced.last
        while True:
            for support in sorted({0.0, last.solution.support}, reverse=True):
                newton = replace(options.newton, support=support)
                point, solution = self.predict_and_correct(traced, step, newton)
                if point is not None:
                    return [point], self._next_step(point, step)
            if step <= options.smallest_step:
                break
            step = max(step / (2 if step > options.short_step else 4), options.smallest_step)
        for recovery in (
            self._step_with_support,
            self._switch_branch,
            self._skip_ahead,
            self._step_in_phase,
            self._switch_branch_reversed,
            self._jump,
        ):
            if points := recovery(traced):
                return points, max(min(points[-1].step, options.first_step), 8 * options.smallest_step)
        raise BranchStoppedError(last.frequency, solution.errors[-1], solution.status)

    def predict_and_correct(
        self, traced: TracedBranch, step: float, newton: NewtonOptions | None = None
    ) -> tuple[BranchPoint | None, Solution]:
        """One step along the tangent and its corrector; no point where the corrector fails, or ends elsewhere than the
        branch goes.

        newton: of the corrector, by default that of the options
        """
        last, newton = traced.last, newton or self.options.newton
        arc = Arc(*_predict(traced.points, step), last.tangent, last.metric)
        # a long step that was given up too early costs a shorter one, a short one perhaps the branch
        if step > self.options.short_step and newton.patience:
            newton = replace(newton, patience=_LESS_PATIENCE)
        solution = solve(self.system, self.excitation, arc.x0, arc.w0, newton, arc)
        if not solution.converged:
            return None, solution
        point = point_after(last, solution, self.excitation)
        near = 0.5 * step < point.step < 1.6 * step
        if near and on_same_branch(last, point) and not traced.contains(point):
            return point, solution
        return None, replace(solution, status=Status.STALLED)

    def _next_step(self, point: BranchPoint, step: float) -> float:
        growth = np.clip(2.0 ** ((self.options.wanted_iterations - point.solution.iterations) / 2), 0.5, 2.0)
        return float(np.clip(max(step, point.step) * growth, self.options.smallest_step, self.options.largest_step))

    def _step_with_support(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """The next point, with another support of the mean position than the last one's; none if that does not help, or
        where the mean position is not among the harmonics.

        The predictor is as good as without: from a residual of 1e-10 the exact step leads far away (`NewtonOptions`).
        """
        if 0 not in self.system.harmonics.orders:
            return []
        for support in (s for s in self.options.supports if s != traced.last.solution.support):
            for step in self.options.no_shorter(self.options.supported_steps):
                point, _ = self.predict_and_correct(traced, step, replace(self.options.newton, support=support))
                if point is not None:
                    return [point]
        return []

    def _switch_branch(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """A point in the direction in which the branch goes on beyond a kink; none if there is none."""
        return self._first_along(self._directions(traced), traced)

    def _switch_branch_reversed(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """As `_switch_branch`, with the orientation reversed."""
        return self._first_along((direction.reversed() for direction in self._directions(traced)), traced)

    def _directions(self, traced: TracedBranch) -> Iterator[BranchDirection]:
        return directions_beyond_kink(self.system, self.excitation, traced.last, self.options.smallest_step)

    def _first_along(self, directions: Iterable[BranchDirection], traced: TracedBranch) -> Sequence[BranchPoint]:
        last = traced.last
        for direction in directions:
            (x, w), (dx, dw) = direction.start, direction.tangent
            for step in direction.steps:
                arc = Arc(x + step * dx, w + step * dw, direction.tangent, last.metric)
                solution = solve(self.system, self.excitation, arc.x0, arc.w0, self.options.newton, arc)
                if not solution.converged:
                    continue
                point = point_after(last, solution, self.excitation)
                straight = last.metric.product(direction.tangent, last.move_to(solution)) > 0.7 * point.step
                if straight and point.step < 3 * step and not lies_on_last_points(traced.points, solution):
                    return [point]
        return []

    def _skip_ahead(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """A point a little ahead, with the orientation kept: where the law, sampled in time, has a discontinuity."""
        lengths = self.options.no_shorter(self.options.skips)
        point = point_beyond_gap(self.system, self.excitation, traced, lengths, self.options.newton)
        return [point] if point is not None and point.orientation == traced.last.orientation else []

    def _step_in_phase(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """A point whose vibration is a little further in phase, at whatever frequency: at resonance the phase goes on
        evenly where the frequency turns round in kinks that lie too close to each other for their far sides to be told
        apart.
        """
        last, harmonics = traced.last, self.system.harmonics
        shift = harmonics.phase_derivative(last.x)
        size = last.metric.length((shift, 0.0))
        if not size:
            return []
        ahead = np.copysign(1 / size, last.metric.product((shift, 0.0), last.tangent))
        for step in self.options.phase_steps:
            plane = Arc(last.x + step * ahead * shift, last.w, (ahead * shift, 0.0), last.metric)
            solution = solve(self.system, self.excitation, plane.x0, plane.w0, self.options.newton, plane)
            if not solution.converged or lies_on_last_points(traced.points, solution):
                continue
            point = point_after(last, solution, self.excitation)
            if step / 2 < point.step < 3 * step and not traced.contains(point):
                return [point]
        return []

    def _jump(self, traced: TracedBranch) -> Sequence[BranchPoint]:
        """The points beyond a jump: from where its far side begins to where the jump ended; none if none is found."""
        lengths = self.options.no_shorter(self.options.jumps)
        for newton in (self.options.newton, self.options.persistent):
            far = point_beyond_gap(self.system, self.excitation, traced, lengths, newton)
            if far is not None:
                return back_to_gap(self._backwards(far), far, traced.last)
        return []

    def _backwards(self, start: BranchPoint) -> Iterator[BranchPoint]:
        """From `start` the other way, until the branch cannot be followed any further."""
        traced, step = TracedBranch([start.turned()]), self.options.first_step
        while step >= self.options.short_step:
            point, _ = self.predict_and_correct(traced, step)
            if point is None:
                step /= 2
                continue
            step = self._next_step(point, step)
            traced = traced.extended([point])
            yield point


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
