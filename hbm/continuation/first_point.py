"""The first point of a branch: a solution at a given frequency, from nothing.

From the stuck response, from the response without any contact, or by continuation in the force at that frequency
(`ForceRamp`), from a force so small that all contacts stick.
"""

from dataclasses import dataclass, replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.predictor_corrector import BranchStoppedError, ContinuationOptions, PredictorCorrector
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.equation import linear_solution, open_solution
from updamp.hbm.newton.newton import NewtonOptions, Solution, Status, solve
from updamp.hbm.problem.system import Excitation, NonlinearSystem

# Most steps in the force; folds of faces that separate take some hundred. Where they were many more, they led nowhere.
_FORCE_STEPS = 400
# `StepLengths.off_predicted` of these steps. Wider than a curve's: any solution at the force begins a curve, which the
# segment from its other end has to meet; a sampled law's branch, which is rough, takes more than those steps with half.
_OFF_PREDICTED = 0.1
# Forces that are tried as small enough, a factor sqrt(10) apart: down to a million times below the one asked for.
_SMALL_FORCES = 13


@dataclass(frozen=True)
class ForceRamp:
    """What varies along a branch at a fixed frequency w [rad/s]: the force on `row`, by its logarithm [ln N]."""

    row: int
    w: float

    def at(self, parameter: float) -> tuple[float, Excitation]:
        return self.w, Excitation(self.row, _force(parameter))

    def rates(self, parameter: float) -> tuple[float, float]:
        return 0.0, _force(parameter)


def _force(parameter: float) -> float:
    """[N], limited: Newton's method may ask for more than a number holds"""
    return float(np.exp(np.clip(parameter, -100.0, 100.0)))


def first_point(
    system: NonlinearSystem, excitation: Excitation, w: float, options: NewtonOptions | None = None
) -> Solution:
    """Solve at w from the stuck response; from the response without any contact; and where neither is near enough,
    along the branch of solutions that leads there from a small force.

    raises: BranchStoppedError where none of them converges
    """
    options = options or NewtonOptions()
    for guess in (linear_solution, open_solution):
        solution = solve(system, excitation, guess(system, w, excitation), w, options)
        if solution.converged:
            return solution
    return by_force_continuation(system, excitation, w, ContinuationOptions(persistent=options))


def by_force_continuation(
    system: NonlinearSystem, excitation: Excitation, w: float, options: ContinuationOptions
) -> Solution:
    """The solution at w at which the branch from a small force first comes to the force asked for.

    With the force below what any contact slips at there is one solution, all stuck. From there the branch is followed
    in the force, back and forth through its folds: where faces separate it turns round many times, so that a force that
    is only raised finds no way on.

    raises: BranchStoppedError where the branch stops, or does not come to that force in `_FORCE_STEPS` steps
    """
    ramp, target = ForceRamp(excitation.row, w), float(np.log(excitation.force))
    options = replace(options, off_predicted=max(options.off_predicted, _OFF_PREDICTED))
    stepper = PredictorCorrector(system, ramp, options, 1.0)
    traced, step = TracedBranch.through([_small_force(system, ramp, target, options)]), options.first_step
    for _ in range(_FORCE_STEPS):
        try:
            points, step = stepper.next_points(traced, min(step, options.largest_step))
        except BranchStoppedError as stop:
            raise BranchStoppedError(w / (2 * np.pi), stop.error, stop.status) from stop
        before, traced = traced.last, traced.extended(points)
        if traced.last.w >= target:
            return _at_force(system, excitation, (before, traced.last), (w, target), options)
    raise BranchStoppedError(w / (2 * np.pi), traced.last.solution.errors[-1], Status.TOO_MANY_ITERATIONS)


def _small_force(system: NonlinearSystem, ramp: ForceRamp, target: float, options: ContinuationOptions) -> BranchPoint:
    """The response to the largest of target, target / sqrt(10), ... at which all stick, or to the smallest of them."""
    log_force = target
    for i in range(_SMALL_FORCES):
        w, excitation = ramp.at(log_force)
        solution = solve(system, ramp, linear_solution(system, w, excitation), log_force, options.persistent)
        stuck = solution.jacobian is not None and not solution.jacobian.n_active
        if solution.converged and (stuck or i == _SMALL_FORCES - 1):
            return point_at(solution, ramp, 1.0, (0 * solution.x, 1.0), 0.0)
        log_force -= np.log(10) / 2
    raise BranchStoppedError(ramp.w / (2 * np.pi), solution.errors[-1], solution.status)


def _at_force(
    system: NonlinearSystem,
    excitation: Excitation,
    neighbours: tuple[BranchPoint, BranchPoint],
    place: tuple[float, float],
    options: ContinuationOptions,
) -> Solution:
    """Between two points of a branch in the force, or beyond them, at the force itself; place: (w, its logarithm)"""
    (a, b), (w, target) = neighbours, place
    share = (target - a.w) / (b.w - a.w)
    for x in (a.x + share * (b.x - a.x), b.x, a.x):
        solution = solve(system, excitation, x, w, options.persistent)
        if solution.converged:
            return solution
    raise BranchStoppedError(w / (2 * np.pi), solution.errors[-1], solution.status)
