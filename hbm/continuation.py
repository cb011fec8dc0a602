"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.branch import BranchPoint, point_after, point_at
from updamp.hbm.corner import Way, leads_back, ways_on
from updamp.hbm.jump import land_beyond, towards_the_gap
from updamp.hbm.metric import Move
from updamp.hbm.newton import Arc, NewtonOptions, Solution, Status, linear_solution, open_solution, solve
from updamp.hbm.succession import goes_on
from updamp.hbm.system import Excitation, NonlinearSystem
from updamp.hbm.traversed import Traversed, traversed

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContinuationOptions:
    """Steps are lengths of arc in the relative metric (hbm/metric.py).

    first_step, smallest_step, largest_step: the corrector's failures shorten the step down to the smallest
    steps_over, leaps: where no smaller step helps and no way round a corner is found, points so far ahead are tried
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    outside: where no first point is found at the end of the window, so far beyond it, in shares of its width
    max_points: at most this many points a branch
    newton: of the corrector; persistent: of a leap, which has no smaller step to fall back on

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-4
    largest_step: float = 0.2
    steps_over: tuple[float, ...] = (3e-4, 1e-3, 3e-3, 0.01)
    leaps: tuple[float, ...] = (0.03, 0.1, 0.2, 0.4)
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    outside: tuple[float, ...] = (0.1, 0.2, 0.35, 0.5, 0.8)
    max_points: int = 2000
    newton: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=8, damped=False, patience=5))
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
    """Solve at w from the stuck response; where that is too far, the force is raised in steps, halved as needed; and
    where these become too small, from the response without any contact.

    raises: BranchStoppedError where none of them converges
    """
    options = options or NewtonOptions()
    solution = solve(system, excitation, linear_solution(system, w, excitation), w, options)
    if solution.converged:
        return solution
    raised = _by_force(system, excitation, w, options)
    if raised.converged:
        return raised
    solution = solve(system, excitation, open_solution(system, w, excitation), w, options)
    if solution.converged:
        return solution
    raise BranchStoppedError(w / (2 * np.pi), raised.errors[-1], raised.status)


def _by_force(system: NonlinearSystem, excitation: Excitation, w: float, options: NewtonOptions) -> Solution:
    """From no force to all of it; the last attempt where the steps become too small."""
    share, step = 0.0, 0.25
    x = np.zeros_like(linear_solution(system, w, excitation))
    while True:
        share_next = min(1.0, share + step)
        guess = x * (share_next / share) if share else share_next * linear_solution(system, w, excitation)
        ramped = solve(system, Excitation(excitation.row, share_next * excitation.force), guess, w, options)
        if ramped.converged:
            share, x, step = share_next, ramped.x, 1.5 * step
        else:
            step /= 2
        if share >= 1.0 or step < 5e-4:
            return ramped


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
    walk, points = Walk(system, excitation, options, scale_w), list(resume_from)
    low, high = (2 * np.pi * f for f in window)
    behind = traversed(points or walk.into(low, high, upwards))
    handed_out = len(points)
    if not points:
        yield from behind.points[-2:]
        handed_out += len(behind.points[-2:])
    step = max(behind.last.step, options.first_step) if len(behind.points) > 1 else options.first_step
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

    def into(self, low: float, high: float, upwards: bool) -> Sequence[BranchPoint]:
        """Points up to the first one in the window [rad/s]: that at its end, or those of a branch that begins outside
        and leads in. Off resonance the contacts bear less, and a first point is found where it is not at the end.

        raises: BranchStoppedError that says what stopped the attempt at the end itself
        """
        end, sign = (low, 1.0) if upwards else (high, -1.0)
        stopped: BranchStoppedError | None = None
        for share in (0.0, *self.options.outside):
            w = end - sign * share * (high - low)
            try:
                solution = first_point(self.system, self.excitation, w, self.options.persistent)
                start = point_at(solution, self.excitation, self.scale_w, (0 * solution.x, sign), 0.0)
                if not share:
                    return [start]
                if inside := self._as_far_as(start, low, high):
                    return inside
            except BranchStoppedError as stop:
                stopped = stopped or stop
        assert stopped is not None, "the attempt at the end has returned or stopped"
        raise stopped

    def _as_far_as(self, start: BranchPoint, low: float, high: float) -> Sequence[BranchPoint]:
        """From `start` into the window; none where the branch turns away from it."""
        behind, step = traversed([start]), self.options.first_step
        away = max(low - start.w, start.w - high)
        for _ in range(self.options.max_points):
            following, step = self.following(behind, min(step, self.options.largest_step))
            behind, last = behind.then(following), following[-1]
            if low <= last.w <= high:
                return behind.points
            if max(low - last.w, last.w - high) > away:
                break
        return []

    def following(self, behind: Traversed, step: float) -> tuple[Sequence[BranchPoint], float]:
        """The next point, or those beyond a jump, and the step to try after them.

        raises: BranchStoppedError
        """
        options, last = self.options, behind.last
        while True:
            point, solution = self.forward(behind, step)
            if point is not None:
                return [point], self._next_step(point, step)
            if step <= options.smallest_step:
                break
            step = max(step / (2 if step > _SHORT else 4), options.smallest_step)
        for further in (self._round_the_corner, self._over_a_step, self._other_way, self._leap):
            beyond = further(behind) if step < _SHORT else ()
            if beyond:
                return beyond, max(min(beyond[-1].step, options.first_step), 8 * options.smallest_step)
        raise BranchStoppedError(last.frequency, solution.errors[-1], solution.status)

    def forward(self, behind: Traversed, step: float) -> tuple[BranchPoint | None, Solution]:
        """The corrector from a step along the tangent; no point where it fails, strays from there, or leads back."""
        last = behind.last
        arc = Arc(*_predict(behind.points, step), last.tangent, last.metric)
        # a long step that was given up too early costs a shorter one, a short one perhaps the branch
        newton = replace(self.options.newton, patience=_LESS_PATIENCE) if step > _SHORT else self.options.newton
        solution = solve(self.system, self.excitation, arc.x0, arc.w0, newton, arc)
        if not solution.converged:
            return None, solution
        point = point_after(last, solution, self.excitation)
        near = 0.5 * step < point.step < 1.6 * step
        if near and goes_on(last, point) and not behind.meets(point):
            return point, solution
        return None, replace(solution, status=Status.STALLED)

    def _round_the_corner(self, behind: Traversed) -> Sequence[BranchPoint]:
        """A point in the direction in which the branch goes on beyond a kink; none if there is none."""
        return self._first_of(ways_on(self.system, self.excitation, behind.last), behind)

    def _other_way(self, behind: Traversed) -> Sequence[BranchPoint]:
        """As `_round_the_corner`, with the orientation changed."""
        ways = ways_on(self.system, self.excitation, behind.last)
        return self._first_of((way.reversed() for way in ways), behind)

    def _first_of(self, ways: Iterable[Way], behind: Traversed) -> Sequence[BranchPoint]:
        last = behind.last
        for way in ways:
            (x, w), (dx, dw) = way.start, way.along
            for step in way.steps:
                arc = Arc(x + step * dx, w + step * dw, way.along, last.metric)
                solution = solve(self.system, self.excitation, arc.x0, arc.w0, self.options.newton, arc)
                if not solution.converged:
                    continue
                point = point_after(last, solution, self.excitation)
                straight = last.metric.product(way.along, last.to(solution)) > 0.7 * point.step
                if straight and point.step < 3 * step and not leads_back(behind.points, solution):
                    return [point]
        return []

    def _over_a_step(self, behind: Traversed) -> Sequence[BranchPoint]:
        """A point a little ahead, with the orientation kept: where the law, sampled in time, has a step."""
        point = land_beyond(self.system, self.excitation, behind, self.options.steps_over, self.options.newton)
        return [point] if point is not None and point.orientation == behind.last.orientation else []

    def _next_step(self, point: BranchPoint, step: float) -> float:
        growth = np.clip(2.0 ** ((self.options.wanted_iterations - point.solution.iterations) / 2), 0.5, 2.0)
        return float(np.clip(max(step, point.step) * growth, self.options.smallest_step, self.options.largest_step))

    def _leap(self, behind: Traversed) -> Sequence[BranchPoint]:
        """The points beyond a jump: from where its far side begins to where the leap landed; none if none is found."""
        for newton in (self.options.newton, self.options.persistent):
            landed = land_beyond(self.system, self.excitation, behind, self.options.leaps, newton)
            if landed is not None:
                return towards_the_gap(self._backwards(landed), landed, behind.last)
        return []

    def _backwards(self, start: BranchPoint) -> Iterator[BranchPoint]:
        """From `start` the other way, until the branch cannot be followed any further."""
        turned = replace(start, tangent_x=-start.tangent_x, tangent_w=-start.tangent_w)
        behind, step = Traversed([turned]), self.options.first_step
        while step >= _SHORT:
            point, _ = self.forward(behind, step)
            if point is None:
                step /= 2
                continue
            step = self._next_step(point, step)
            behind = behind.then([point])
            yield point


# Steps below this are shortened faster: what stops them is a kink.
_SHORT = 0.01
# Iterations after which a longer step is given up unless the residual has fallen.
_LESS_PATIENCE = 4


def _predict(points: Sequence[BranchPoint], step: float) -> Move:
    """Along the tangent, bent by the change of the tangent since the point before (second order)."""
    last = points[-1]
    x, w = last.x + step * last.tangent_x, last.w + step * last.tangent_w
    if len(points) > 1 and last.step > 0 and not last.after_gap:
        before = points[-2]
        bend, length = step**2 / (2 * last.step), last.metric.length(before.tangent)
        # across a corner, and far beyond what it was found from, the change of the tangent says nothing
        if step > 4 * last.step or last.metric.product(before.tangent, last.tangent) < 0.9 * length:
            return x, w
        x = x + bend * (last.tangent_x - before.tangent_x / length)
        w = w + bend * (last.tangent_w - before.tangent_w / length)
    return x, w
