"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points.

The metric is relative: displacements are measured against the size of the current point and frequency against a
given scale, so that steps are even in the logarithm of the amplitude and in the phase, off resonance and on it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.jacobian import factorise
from updamp.hbm.newton import Arc, NewtonOptions, Solution, Status, evaluate, linear_solution, solve
from updamp.hbm.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContinuationOptions:
    """Steps are lengths of arc in the relative metric.

    first_step, smallest_step, largest_step: the corrector's failures halve the step down to the smallest
    secant_below: cosine of the angle between tangent and secant below which the secant is tried too
    leap_below: below this step long ones are tried, over a piece that is rough with corners: `leaps` in length, from
        the last point and from those `rewinds` before it
    kink_step: below this step the corrector's failure is taken for a corner that turns back
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    max_points: at most this many points a branch
    restarts: so many times the branch may be taken up afresh at a point where it stops

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-3
    largest_step: float = 0.2
    secant_below: float = 0.98
    leap_below: float = 0.01
    leaps: tuple[float, ...] = (0.1, 0.05, 0.2, 0.4)
    rewinds: tuple[int, ...] = (0, 8)
    kink_step: float = 2e-3
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    max_points: int = 1500
    restarts: int = 3
    newton: NewtonOptions = field(default_factory=NewtonOptions)

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


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """One solved point.

    x: (n_relative, n_coefficients) [m]; w [rad/s]
    tangent_x, tangent_w: direction of the branch, of unit length in the metric at this point
    step: arc length from the point before; turning: whether the frequency turned round since then
    agreement: cosine of the angle between the tangent here and the move that led here
    """

    x: Floats
    w: float
    tangent_x: Floats
    tangent_w: float
    step: float
    turning: bool
    agreement: float
    solution: Solution

    @property
    def frequency(self) -> float:
        """[Hz]"""
        return self.w / (2 * np.pi)

    @property
    def status(self) -> Status:
        return self.solution.status


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


def distance(a: BranchPoint, b: BranchPoint, scale_w: float) -> float:
    """Length of arc between neighbouring points of a branch, in the metric of continuation."""
    return _distance(b.x - a.x, b.w - a.w, _size(a.x), scale_w)


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
    if resume_from:
        points = list(resume_from)
    else:
        w = 2 * np.pi * (window[0] if upwards else window[1])
        points = [_start(first_point(system, excitation, w, options.newton), excitation, scale_w, upwards)]
        yield points[0]
    step = max(points[-1].step, options.first_step) if len(points) > 1 else options.first_step
    inside = tuple(2 * np.pi * f for f in window)
    restarts = 0
    for _ in range(options.max_points - 1):
        try:
            point, step = _onwards(system, excitation, points, step, scale_w, options)
        except BranchStoppedError:
            if (fresh := _fresh_start(system, excitation, points, scale_w)) is None or restarts >= options.restarts:
                raise
            points, step, restarts = fresh, options.first_step, restarts + 1
            continue
        points = [*points[-_HISTORY:], point]
        restarts = 0 if point.step > options.first_step else restarts
        yield point
        if not inside[0] <= point.w <= inside[1]:
            return


def _onwards(
    system: NonlinearSystem,
    excitation: Excitation,
    points: list[BranchPoint],
    step: float,
    scale_w: float,
    options: ContinuationOptions,
) -> tuple[BranchPoint, float]:
    """The next point and step; a point that runs back over the branch is not taken.

    raises: BranchStoppedError
    """
    if _crawls(points):
        last = points[-1]
        raise BranchStoppedError(last.frequency, last.solution.errors[-1], Status.CRAWLING)
    point, step = _next_point(system, excitation, points, step, scale_w, options)
    if not _retraces(point, points, scale_w):
        return point, step
    # At a corner that is nearly a reversal the tangent was taken the wrong way round: go the other way.
    last = points[-1]
    turned = [*points[:-1], replace(last, tangent_x=-last.tangent_x, tangent_w=-last.tangent_w)]
    leap = _leap(system, excitation, turned, scale_w, options)
    if leap is not None:
        return _point_after(leap, excitation, scale_w, last), options.first_step
    point, step = _next_point(system, excitation, turned, options.kink_step, scale_w, options)
    if _retraces(point, points, scale_w):
        raise BranchStoppedError(point.frequency, point.solution.errors[-1], Status.STALLED)
    return point, step


def _fresh_start(
    system: NonlinearSystem, excitation: Excitation, points: Sequence[BranchPoint], scale_w: float
) -> list[BranchPoint] | None:
    """The last point again, its tangent computed anew and oriented by the way the branch came over a longer piece.

    In a rough piece the direction of the last points is that of their corners; forgetting it often frees the way.
    """
    last, size = points[-1], _size(points[-1].x)
    for earlier in reversed(points[:-1]):
        onwards = (last.x - earlier.x, last.w - earlier.w)
        if _distance(*onwards, size, scale_w) > _LITTLE_WAY:
            return [earlier, branch_point(system, excitation, last.x, last.w, scale_w, onwards)]
    return None


# Points kept to notice a branch that runs back over itself.
_HISTORY = 60


def _crawls(points: Sequence[BranchPoint]) -> bool:
    """Whether the last points together made less way than one ordinary step, and steps do not recover."""
    recent = [p.step for p in points[-_PATIENCE:]]
    return len(points) > _PATIENCE and sum(recent) < _LITTLE_WAY


# Steps double after a success: from the floor, six of them come further than this if nothing is in the way.
_PATIENCE, _LITTLE_WAY = 6, 0.03


def _retraces(point: BranchPoint | Solution, points: Sequence[BranchPoint], scale_w: float) -> bool:
    """Whether the point lies on the piece of the branch that led to the last point, not beyond it."""
    size = _size(points[-1].x)
    step = _distance(point.x - points[-1].x, point.w - points[-1].w, size, scale_w)
    for start, end in pairwise(points):
        along, off = (end.x - start.x, end.w - start.w), (point.x - start.x, point.w - start.w)
        length = _distance(*along, size, scale_w)
        share = _product(along, off, size, scale_w) / length**2
        rest = (off[0] - share * along[0], off[1] - share * along[1])
        if -0.05 < share < 0.95 and _distance(*rest, size, scale_w) < 0.1 * min(length, step):
            return True
    return False


def branch_point(
    system: NonlinearSystem, excitation: Excitation, x: Floats, w: float, scale_w: float, onwards: tuple[Floats, float]
) -> BranchPoint:
    """A point of the branch known to be solved, such as a stored one, with its tangent along `onwards` (dx, dw)."""
    equation = evaluate(system, excitation, x, w)
    jacobian = factorise(equation.receptance, equation.departure)
    solution = Solution(x, w, Status.CONVERGED, 0, (equation.error,), equation, jacobian)
    tangent_x, tangent_w = _tangent(solution, excitation, scale_w, _size(x))
    dx, dw = onwards
    sign = 1.0 if _product((tangent_x, tangent_w), onwards, _size(x), scale_w) > 0 else -1.0
    moved = _distance(dx, dw, _size(x), scale_w)
    return BranchPoint(x, w, sign * tangent_x, sign * tangent_w, moved, False, 1.0, solution)


def _start(solution: Solution, excitation: Excitation, scale_w: float, upwards: bool) -> BranchPoint:
    tangent_x, tangent_w = _tangent(solution, excitation, scale_w, _size(solution.x))
    sign = 1.0 if upwards else -1.0
    return BranchPoint(solution.x, solution.w, sign * tangent_x, sign * tangent_w, 0.0, False, 1.0, solution)


def _point_after(solution: Solution, excitation: Excitation, scale_w: float, last: BranchPoint) -> BranchPoint:
    """The solution with the direction to go on in: the tangent, oriented onwards, where it agrees with the move that
    led here, and else the move itself. Where many contacts change state the tangent is that of a tiny piece of the
    branch between two corners and says little about where the branch leads.
    """
    size, move = _size(last.x), (solution.x - last.x, solution.w - last.w)
    moved = _distance(*move, size, scale_w)
    dx, dw = _tangent(solution, excitation, scale_w, size)
    agreement = _product(move, (dx, dw), size, scale_w) / moved
    if abs(agreement) < _SMOOTH:
        dx, dw, agreement = move[0] / moved, move[1] / moved, 1.0
    rescale = np.sign(agreement) / _distance(dx, dw, _size(solution.x), scale_w)
    dx, dw = rescale * dx, rescale * dw
    return BranchPoint(solution.x, solution.w, dx, dw, moved, dw * last.tangent_w < 0, abs(agreement), solution)


# Cosine of the angle between tangent and move above which the tangent is trusted.
_SMOOTH = 0.7


def _product(a: tuple[Floats, float], b: tuple[Floats, float], size: float, scale_w: float) -> float:
    """Inner product of two directions (dx, dw) in the relative metric."""
    return float(np.vdot(a[0], b[0]) / size**2 + a[1] * b[1] / scale_w**2)


def _tangent(solution: Solution, excitation: Excitation, scale_w: float, size: float) -> tuple[Floats, float]:
    """Unit tangent (dx, dw) of the branch, increasing w, from the last Jacobian."""
    if solution.by_frequency is not None:
        dx = -solution.by_frequency
    else:
        assert solution.jacobian is not None, "a converged solution carries its Jacobian"
        dx = -solution.jacobian.solve(solution.equation.frequency_derivative(excitation))
    length = _distance(dx, 1.0, size, scale_w)
    return dx / length, 1 / length


def _distance(dx: Floats, dw: float, size: float, scale_w: float) -> float:
    """Length in the relative metric."""
    return float(np.sqrt(np.sum(dx**2) / size**2 + dw**2 / scale_w**2))


def _size(x: Floats) -> float:
    return max(float(np.linalg.norm(x)), np.finfo(float).tiny)


def _next_point(
    system: NonlinearSystem,
    excitation: Excitation,
    points: Sequence[BranchPoint],
    step: float,
    scale_w: float,
    options: ContinuationOptions,
) -> tuple[BranchPoint, float]:
    """The following point and the step to try after it; the step is halved until the corrector succeeds."""
    last, leapt = points[-1], False
    while True:
        solution = _forward(system, excitation, points, step, scale_w, options)
        if solution is None and step < options.leap_below and not leapt:
            solution, leapt = _leap(system, excitation, points, scale_w, options), True
        if solution is None and step < options.kink_step:
            solution = _round_a_kink(system, excitation, points, step, scale_w, options)
        if solution is not None:
            break
        if step / 2 < options.smallest_step:
            x, w = _predict(points, step)
            arc = Arc(x, w, last.tangent_x, last.tangent_w, _size(last.x), scale_w)
            failed = solve(system, excitation, x, w, options.newton, arc)
            status = Status.STALLED if failed.converged else failed.status
            raise BranchStoppedError(last.frequency, failed.errors[-1], status)
        step /= 2
    point = _point_after(solution, excitation, scale_w, last)
    growth = np.clip(2.0 ** ((options.wanted_iterations - solution.iterations) / 2), 0.5, 2.0)
    return point, float(np.clip(max(step, point.step) * growth, options.smallest_step, options.largest_step))


def _forward(
    system: NonlinearSystem,
    excitation: Excitation,
    points: Sequence[BranchPoint],
    step: float,
    scale_w: float,
    options: ContinuationOptions,
) -> Solution | None:
    """One step along the tangent, or else along the secant: near many small corners it is the better guess."""
    last, size = points[-1], _size(points[-1].x)
    x, w = _predict(points, step)
    arc = Arc(x, w, last.tangent_x, last.tangent_w, size, scale_w)
    solution = _corrected(system, excitation, last, arc, step, options)
    if solution is not None or len(points) < 2:
        return solution
    dx, dw = last.x - points[-2].x, last.w - points[-2].w
    length = _distance(dx, dw, size, scale_w)
    dx, dw = dx / length, dw / length
    if _product((dx, dw), (last.tangent_x, last.tangent_w), size, scale_w) > options.secant_below:
        return None
    arc = Arc(last.x + step * dx, last.w + step * dw, dx, dw, size, scale_w)
    return _corrected(system, excitation, last, arc, step, options)


def _leap(
    system: NonlinearSystem,
    excitation: Excitation,
    points: Sequence[BranchPoint],
    scale_w: float,
    options: ContinuationOptions,
) -> Solution | None:
    """One long step over a rough piece, where contacts change state so often that short steps meet corner after
    corner. It starts at the last point or at an earlier one, from before the rough piece.
    """
    last, size = points[-1], _size(points[-1].x)
    for back in options.rewinds:
        if back >= len(points) - 1:
            break
        run_up = points[: len(points) - back]
        base = run_up[-1]
        gap = _distance(last.x - base.x, last.w - base.w, size, scale_w)
        for length in options.leaps:
            for x, w in _guesses(run_up, gap + length, scale_w):
                solution = _leapt(system, excitation, points, base, (x, w), scale_w, options)
                if solution is not None:
                    return solution
    return None


def _guesses(points: Sequence[BranchPoint], ahead: float, scale_w: float) -> Iterator[tuple[Floats, float]]:
    """Places `ahead` of the last point: by a parabola through points as far apart as that, and along the tangent."""
    last, size = points[-1], _size(points[-1].x)
    apart = [_distance(p.x - last.x, p.w - last.w, size, scale_w) for p in points]
    near = next((i for i in reversed(range(len(points))) if apart[i] > ahead / 2), None)
    far = next((i for i in reversed(range(len(points))) if near is not None and apart[i] > 1.5 * apart[near]), None)
    if near is not None and far is not None:
        yield _parabola((points[far], points[near], last), (-apart[far], -apart[near]), ahead)
    yield last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w


def _leapt(
    system: NonlinearSystem,
    excitation: Excitation,
    points: Sequence[BranchPoint],
    base: BranchPoint,
    guess: tuple[Floats, float],
    scale_w: float,
    options: ContinuationOptions,
) -> Solution | None:
    """The solution near the guess, if there is one beyond the last point and not on what was traversed."""
    last, size = points[-1], _size(points[-1].x)
    dx, dw = guess[0] - base.x, guess[1] - base.w
    length = _distance(dx, dw, size, scale_w)
    arc = Arc(*guess, dx / length, dw / length, size, scale_w)
    solution = _corrected(system, excitation, base, arc, length, options)
    if solution is None or _retraces(solution, points, scale_w):
        return None
    onwards = (solution.x - last.x, solution.w - last.w)
    beyond = _product(onwards, (arc.tangent_x, arc.tangent_w), size, scale_w)
    near = _distance(*onwards, size, scale_w) < 2 * max(options.leaps)  # not on some other branch
    return solution if beyond > 0 and near else None


def _parabola(
    points: tuple[BranchPoint, BranchPoint, BranchPoint], at: tuple[float, float], ahead: float
) -> tuple[Floats, float]:
    """Extrapolate from places at[0], at[1] and 0 along the branch to `ahead`."""
    a, b = at
    weights = (
        ahead * (ahead - b) / (a * (a - b)),
        ahead * (ahead - a) / (b * (b - a)),
        (ahead - a) * (ahead - b) / (a * b),
    )
    x = sum((c * p.x for c, p in zip(weights, points, strict=True)), start=np.zeros_like(points[0].x))
    return x, sum(c * p.w for c, p in zip(weights, points, strict=True))


def _corrected(
    system: NonlinearSystem,
    excitation: Excitation,
    last: BranchPoint,
    arc: Arc,
    step: float,
    options: ContinuationOptions,
) -> Solution | None:
    """The solution on the arc, if there is one about a step away from the last point."""
    solution = solve(system, excitation, arc.x0, arc.w0, options.newton, arc)
    moved = _distance(solution.x - last.x, solution.w - last.w, arc.scale_x, arc.scale_w)
    return solution if solution.converged and 0.5 * step < moved < 1.6 * step else None


def _round_a_kink(
    system: NonlinearSystem,
    excitation: Excitation,
    points: Sequence[BranchPoint],
    step: float,
    scale_w: float,
    options: ContinuationOptions,
) -> Solution | None:
    """Where many contacts change their state at once the branch has a corner, and may turn back sharply in it.

    Beyond the corner other tangents hold: they are taken a little ahead, and followed both ways; the way by which
    the branch came does not count.
    """
    last, before = points[-1], points[-2] if len(points) > 1 else None
    size = _size(last.x)
    for ahead in (1.0, 4.0, 0.25):
        x, w = last.x + ahead * step * last.tangent_x, last.w + ahead * step * last.tangent_w
        equation = evaluate(system, excitation, x, w)
        jacobian = factorise(equation.receptance, equation.departure)
        beyond = Solution(x, w, Status.CONVERGED, 0, (equation.error,), equation, jacobian)
        dx, dw = _tangent(beyond, excitation, scale_w, size)
        for sign in (-1.0, 1.0):
            for length in (step, 8 * step, 64 * step):
                arc = Arc(last.x + sign * length * dx, last.w + sign * length * dw, sign * dx, sign * dw, size, scale_w)
                solution = _corrected(system, excitation, last, arc, length, options)
                if solution is not None and not _back_the_way(solution, last, before, size, scale_w):
                    return solution
    return None


def _back_the_way(
    solution: Solution, last: BranchPoint, before: BranchPoint | None, size: float, scale_w: float
) -> bool:
    """Whether the solution lies on the part of the branch that was just traversed."""
    if before is None:
        came_x, came_w = -last.tangent_x, -last.tangent_w
    else:
        came_x, came_w = before.x - last.x, before.w - last.w
    dx, dw = solution.x - last.x, solution.w - last.w
    product = _product((came_x, came_w), (dx, dw), size, scale_w)
    lengths = _distance(dx, dw, size, scale_w) * _distance(came_x, came_w, size, scale_w)
    return bool(product > 0.95 * lengths)


def _predict(points: Sequence[BranchPoint], step: float) -> tuple[Floats, float]:
    """Tangent, bent by the change of the tangent since the point before (second order)."""
    last = points[-1]
    x, w = last.x + step * last.tangent_x, last.w + step * last.tangent_w
    if len(points) > 1 and last.step > 0:
        before = points[-2]
        bend = step**2 / (2 * last.step)
        x = x + bend * (last.tangent_x - before.tangent_x * _size(last.x) / _size(before.x))
        w = w + bend * (last.tangent_w - before.tangent_w)
    return x, w
