"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.branch import BranchPoint, point_after, point_at
from updamp.hbm.jump import land_beyond, towards_the_gap
from updamp.hbm.metric import Move
from updamp.hbm.newton import Arc, NewtonOptions, Solution, Status, linear_solution, solve
from updamp.hbm.system import Excitation, NonlinearSystem
from updamp.hbm.traversed import Traversed, traversed

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContinuationOptions:
    """Steps are lengths of arc in the relative metric (hbm/metric.py).

    first_step, smallest_step, largest_step: the corrector's failures halve the step down to the smallest
    leap_below: below this step, points `leaps` ahead are tried: over a place where the response jumps
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    max_points: at most this many points a branch
    newton: of the corrector; persistent: of a leap, which has no smaller step to fall back on

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-3
    largest_step: float = 0.2
    leap_below: float = 0.01
    leaps: tuple[float, ...] = (0.05, 0.1, 0.2, 0.4)
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    max_points: int = 800
    newton: NewtonOptions = field(default_factory=lambda: NewtonOptions(smallest_damping=1 / 8))
    persistent: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=20))

    def scale_w(self, window: tuple[float, float]) -> float:
        """Angular frequency that counts as one unit of arc [rad/s]; window [Hz]."""
        return 2 * np.pi * self.frequency_scale * (window[1] - window[0])

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step < self.first_step <= self.largest_step:
            raise ValueError(
                f"steps {self.smallest_step}, {self.first_step}, {self.largest_step}: "
                "0 < smallest_step < first_step <= largest_step is needed"
            )
        if self.frequency_scale <= 0 or self.max_points < 2:
            raise ValueError("frequency_scale must be positive and max_points at least 2")


class BranchStoppedError(Exception):
    """A branch that cannot go on. What was computed has been handed out already."""

    def __init__(self, frequency: float, error: float, status: Status) -> None:
        self.frequency, self.error, self.status = frequency, error, status
        super().__init__(
            f"the branch stops at {frequency:.4f} Hz: {status.value}, residual {error:.1e} of the displacement; "
            f"{status.advice}"
        )


def first_point(
    system: NonlinearSystem, excitation: Excitation, w: float, options: NewtonOptions | None = None
) -> Solution:
    """Solve at w from the stuck response; where that is too far, the force is raised in steps, halved as needed.

    raises: BranchStoppedError where no step of the force is small enough
    """
    options = options or NewtonOptions()
    solution = solve(system, excitation, linear_solution(system, w, excitation), w, options)
    if solution.converged:
        return solution
    share, step, x = 0.0, 0.25, np.zeros_like(solution.x)
    while share < 1.0:
        share_next = min(1.0, share + step)
        guess = x * (share_next / share) if share else share_next * linear_solution(system, w, excitation)
        ramped = solve(system, Excitation(excitation.row, share_next * excitation.force), guess, w, options)
        if ramped.converged:
            share, x, solution, step = share_next, ramped.x, ramped, 1.5 * step
        elif step < 1e-3:
            raise BranchStoppedError(w / (2 * np.pi), ramped.errors[-1], ramped.status)
        else:
            step /= 2
    return solution


def continue_branch(
    system: NonlinearSystem,
    excitation: Excitation,
    window: tuple[float, float],
    options: ContinuationOptions | None = None,
    upwards: bool = True,
    resume_from: Sequence[BranchPoint] = (),
) -> Iterator[BranchPoint]:
    """Points of the branch through `window` [Hz], from its lower end (or upper: upwards=False) until it leaves it.

    resume_from: the last points of an interrupted branch; the first point handed out is the one that follows

    raises: BranchStoppedError where the step would fall below its floor
    """
    options = options or ContinuationOptions()
    scale_w = options.scale_w(window)
    points = list(resume_from)
    if not points:
        w = 2 * np.pi * (window[0] if upwards else window[1])
        solution = first_point(system, excitation, w, options.persistent)
        points = [point_at(solution, excitation, scale_w, (0 * solution.x, 1.0 if upwards else -1.0), 0.0)]
        yield points[0]
    walk, behind = Walk(system, excitation, options, scale_w), traversed(points)
    step = max(points[-1].step, options.first_step) if len(points) > 1 else options.first_step
    low, high = (2 * np.pi * f for f in window)
    handed_out = len(points)
    while handed_out < options.max_points:
        following, step = walk.following(behind, min(step, options.largest_step))
        yield from following
        handed_out += len(following)
        behind = behind.then(following)
        if not low <= behind.last.w <= high:
            return


@dataclass(frozen=True, eq=False)
class Walk:
    """One branch: how its points follow each other."""

    system: NonlinearSystem
    excitation: Excitation
    options: ContinuationOptions
    scale_w: float

    def following(self, behind: Traversed, step: float) -> tuple[Sequence[BranchPoint], float]:
        """The next point, or those beyond a jump, and the step to try after them.

        raises: BranchStoppedError
        """
        options, last, leapt = self.options, behind.last, False
        while True:
            solution = self.forward(behind, step)
            if solution.converged:
                return self._accepted(last, solution, step)
            if step < options.leap_below and not leapt:
                leapt = True
                beyond = self._leap(behind)
                if beyond:
                    return beyond, options.first_step
            if step / 2 < options.smallest_step:
                solution = self.forward(behind, step, around_corner=True)
                if solution.converged:
                    return self._accepted(last, solution, step)
                raise BranchStoppedError(last.frequency, solution.errors[-1], solution.status)
            step /= 2

    def forward(self, behind: Traversed, step: float, around_corner: bool = False) -> Solution:
        """The corrector from a step along the tangent; one that strays from there, or back, counts as stalled.

        around_corner: the branch may turn away from the tangent so sharply that it meets the plane of even the
        smallest step some way off
        """
        last = behind.last
        arc = Arc(*_predict(behind.points, step), last.tangent, last.metric)
        solution = solve(self.system, self.excitation, arc.x0, arc.w0, self.options.newton, arc)
        farthest = self.options.leap_below if around_corner else 1.6 * step
        near = 0.5 * step < last.distance(solution) < farthest
        if solution.converged and (not near or behind.meets(solution)):
            return replace(solution, status=Status.STALLED)
        return solution

    def _accepted(self, last: BranchPoint, solution: Solution, step: float) -> tuple[Sequence[BranchPoint], float]:
        point, moved = point_after(last, solution, self.excitation), last.distance(solution)
        growth = np.clip(2.0 ** ((self.options.wanted_iterations - solution.iterations) / 2), 0.5, 2.0)
        return [point], float(np.clip(max(step, moved) * growth, self.options.smallest_step, self.options.largest_step))

    def _leap(self, behind: Traversed) -> Sequence[BranchPoint]:
        """The points beyond a jump: from where its far side begins to where the leap landed; none if none is found."""
        landed = land_beyond(self.system, self.excitation, behind, self.options.leaps, self.options.persistent)
        if landed is None:
            return []
        last = behind.last
        point = point_at(landed, self.excitation, self.scale_w, last.to(landed), last.distance(landed), after_gap=True)
        return towards_the_gap(self._backwards(point), point, last)

    def _backwards(self, start: BranchPoint) -> Iterator[BranchPoint]:
        """From `start` the other way, until the branch cannot be followed any further."""
        turned = replace(start, tangent_x=-start.tangent_x, tangent_w=-start.tangent_w)
        behind, step = Traversed([turned]), self.options.first_step
        while step >= self.options.leap_below:
            solution = self.forward(behind, step)
            if not solution.converged:
                step /= 2
                continue
            (point,), step = self._accepted(behind.last, solution, step)
            behind = behind.then([point])
            yield point


def _predict(points: Sequence[BranchPoint], step: float) -> Move:
    """Along the tangent, bent by the change of the tangent since the point before (second order)."""
    last = points[-1]
    x, w = last.x + step * last.tangent_x, last.w + step * last.tangent_w
    if len(points) > 1 and last.step > 0 and not last.after_gap:
        before = points[-2]
        bend, length = step**2 / (2 * last.step), last.metric.length(before.tangent)
        x = x + bend * (last.tangent_x - before.tangent_x / length)
        w = w + bend * (last.tangent_w - before.tangent_w / length)
    return x, w
