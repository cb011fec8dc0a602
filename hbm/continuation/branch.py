"""A solved point of a branch, with its direction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.metric import Metric, Move
from updamp.hbm.newton.newton import Solution, Status
from updamp.hbm.problem.system import Forcing, NonlinearSystem

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """x: (n_relative, n_coefficients) [m]; w [rad/s]

    tangent_x, tangent_w: direction of the branch, of unit length in `metric`
    step: length from the point before; after_gap: whether the branch was not followed from there
    """

    x: Floats
    w: float
    tangent_x: Floats
    tangent_w: float
    metric: Metric
    step: float
    after_gap: bool
    solution: Solution

    @property
    def frequency(self) -> float:
        """[Hz]"""
        return self.w / (2 * np.pi)

    @property
    def status(self) -> Status:
        return self.solution.status

    @property
    def tangent(self) -> Move:
        return self.tangent_x, self.tangent_w

    @property
    def orientation(self) -> float | None:
        """Sign of det J times that of dw/ds, which stays along a branch; None where det J would cost too much."""
        jacobian = self.solution.jacobian
        if jacobian is None or not jacobian.sign_is_cheap:
            return None
        return jacobian.determinant_sign * float(np.sign(self.tangent_w))

    def without_equations(self) -> Self:
        """The same point without what its equations were solved with, some 10 MB for 150 contacts."""
        return replace(self, solution=replace(self.solution, jacobian=None, by_frequency=None))

    def turned(self) -> Self:
        """The same point with the branch's direction turned round."""
        return replace(self, tangent_x=-self.tangent_x, tangent_w=-self.tangent_w)

    def move_to(self, other: "BranchPoint | Solution") -> Move:
        return other.x - self.x, other.w - self.w

    def distance(self, other: "BranchPoint | Solution") -> float:
        """Length of arc to a neighbouring point, in the metric at this one."""
        return self.metric.length(self.move_to(other))


def point_at(
    solution: Solution, excitation: Forcing, scale_w: float, direction: Move, step: float, after_gap: bool = False
) -> BranchPoint:
    """The solution with the branch's tangent there, on the side of `direction` (dx, dw)."""
    equation = solution.equation
    metric = Metric.at(solution.x, equation.receptance.system.harmonics, scale_w, equation.least)
    dx, dw = _tangent(solution, excitation)
    length = metric.length((dx, dw))
    if metric.product((dx, dw), direction) < 0:
        length = -length
    return BranchPoint(solution.x, solution.w, dx / length, dw / length, metric, step, after_gap, solution)


def other_way_round(points: Sequence[BranchPoint]) -> list[BranchPoint]:
    """The same points in the opposite direction."""
    steps = [(0.0, False), *((point.step, point.after_gap) for point in reversed(points[1:]))]
    return [
        replace(point.turned(), step=step, after_gap=gap)
        for point, (step, gap) in zip(reversed(points), steps, strict=True)
    ]


def point_after(last: BranchPoint, solution: Solution, excitation: Forcing) -> BranchPoint:
    """The solution a step from the last point, with the tangent on the side of the move that led here."""
    move = last.move_to(solution)
    return point_at(solution, excitation, last.metric.scale_w, move, last.metric.length(move))


def branch_point(
    system: NonlinearSystem, excitation: Forcing, x: Floats, w: float, scale_w: float, direction: Move
) -> BranchPoint:
    """A point known to be solved, such as a stored one, with its tangent along `direction` (dx, dw)."""
    equation = evaluate(system, excitation, x, w)
    jacobian = equation.factorised()
    solution = Solution(x, w, Status.CONVERGED, 0, (equation.error,), equation, jacobian)
    step = Metric.at(x, system.harmonics, scale_w, equation.least).length(direction)
    return point_at(solution, excitation, scale_w, direction, step)


def _tangent(solution: Solution, excitation: Forcing) -> Move:
    """Direction of the branch for a unit of angular frequency, by the last Jacobian."""
    if solution.by_frequency is not None:
        return -solution.by_frequency, 1.0
    assert solution.jacobian is not None, "a converged solution carries its Jacobian"
    return -solution.jacobian.solve(solution.equation.frequency_derivative(excitation)), 1.0
