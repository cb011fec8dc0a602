"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points.

The metric is relative: displacements are measured against the size of the current point and frequency against a
given scale, so that steps are even in the logarithm of the amplitude and in the phase, off resonance and on it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

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
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    max_points: at most this many points a branch

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-6
    largest_step: float = 0.2
    wanted_iterations: int = 4
    frequency_scale: float = 0.5
    max_points: int = 1500
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
    """

    x: Floats
    w: float
    tangent_x: Floats
    tangent_w: float
    step: float
    turning: bool
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
        points = list(resume_from[-2:])
    else:
        w = 2 * np.pi * (window[0] if upwards else window[1])
        points = [_start(first_point(system, excitation, w, options.newton), excitation, scale_w, upwards)]
        yield points[0]
    step = max(points[-1].step, options.first_step) if len(points) > 1 else options.first_step
    inside = tuple(2 * np.pi * f for f in window)
    for _ in range(options.max_points - 1):
        point, step = _next_point(system, excitation, points, step, scale_w, options)
        points = [points[-1], point]
        yield point
        if not inside[0] <= point.w <= inside[1]:
            return


def branch_point(
    system: NonlinearSystem, excitation: Excitation, x: Floats, w: float, scale_w: float, onwards: tuple[Floats, float]
) -> BranchPoint:
    """A point of the branch known to be solved, such as a stored one, with its tangent along `onwards` (dx, dw)."""
    equation = evaluate(system, excitation, x, w)
    jacobian = factorise(equation.receptance, equation.departure)
    solution = Solution(x, w, Status.CONVERGED, 0, (equation.error,), equation, jacobian)
    tangent_x, tangent_w = _tangent(solution, excitation, scale_w)
    size = _size(x)
    dx, dw = onwards
    sign = 1.0 if np.vdot(tangent_x, dx) / size**2 + tangent_w * dw / scale_w**2 > 0 else -1.0
    moved = float(np.sqrt(np.sum(dx**2) / size**2 + dw**2 / scale_w**2))
    return BranchPoint(x, w, sign * tangent_x, sign * tangent_w, moved, False, solution)


def _start(solution: Solution, excitation: Excitation, scale_w: float, upwards: bool) -> BranchPoint:
    tangent_x, tangent_w = _tangent(solution, excitation, scale_w)
    sign = 1.0 if (tangent_w > 0) == upwards else -1.0
    return BranchPoint(solution.x, solution.w, sign * tangent_x, sign * tangent_w, 0.0, False, solution)


def _tangent(solution: Solution, excitation: Excitation, scale_w: float) -> tuple[Floats, float]:
    """Unit tangent (dx, dw) of the branch, increasing w, from the last factorised Jacobian."""
    assert solution.jacobian is not None, "a converged solution carries its Jacobian"
    dx = -solution.jacobian.solve(solution.equation.frequency_derivative(excitation))
    length = np.sqrt(np.sum(dx**2) / _size(solution.x) ** 2 + 1 / scale_w**2)
    return dx / length, 1 / length


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
    last = points[-1]
    size = _size(last.x)
    while True:
        x, w = _predict(points, step)
        arc = Arc(x, w, last.tangent_x, last.tangent_w, size, scale_w)
        solution = solve(system, excitation, x, w, options.newton, arc)
        dx, dw = solution.x - last.x, solution.w - last.w
        moved = np.sqrt(np.sum(dx**2) / size**2 + dw**2 / scale_w**2)
        if solution.converged and 0.3 * step < moved < 3 * step:
            break
        if step / 2 < options.smallest_step:
            status = Status.STALLED if solution.converged else solution.status
            raise BranchStoppedError(last.frequency, solution.errors[-1], status)
        step /= 2
    tangent_x, tangent_w = _tangent(solution, excitation, scale_w)
    if np.vdot(tangent_x, dx) / size**2 + tangent_w * dw / scale_w**2 < 0:
        tangent_x, tangent_w = -tangent_x, -tangent_w
    turning = tangent_w * last.tangent_w < 0
    point = BranchPoint(solution.x, solution.w, tangent_x, tangent_w, float(moved), turning, solution)
    growth = np.clip(2.0 ** ((options.wanted_iterations - solution.iterations) / 2), 0.5, 2.0)
    return point, float(np.clip(step * growth, options.smallest_step, options.largest_step))


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
