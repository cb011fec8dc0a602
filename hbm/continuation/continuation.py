"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points."""

from collections.abc import Iterator, Sequence

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.first_point import first_point
from updamp.hbm.continuation.predictor_corrector import BranchStoppedError, ContinuationOptions, PredictorCorrector
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.problem.system import Excitation, NonlinearSystem

__all__ = ["BranchStoppedError", "ContinuationOptions", "continue_branch", "first_point"]


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
    stepper = PredictorCorrector(system, excitation, options, options.scale_w(window))
    low, high = (2 * np.pi * f for f in window)
    traced = TracedBranch.through(list(resume_from) or _first_points(stepper, excitation, low, high, upwards))
    handed_out = len(resume_from)
    if not handed_out:
        yield from traced.points[-2:]
        handed_out += len(traced.points[-2:])
    step = max(traced.last.step, options.first_step) if len(traced.points) > 1 else options.first_step
    while handed_out < options.max_points:
        points, step = stepper.next_points(traced, min(step, options.largest_step))
        yield from points
        handed_out += len(points)
        traced = traced.extended(points)
        if not low <= traced.last.w <= high:
            return


def _first_points(
    stepper: PredictorCorrector, excitation: Excitation, low: float, high: float, upwards: bool
) -> Sequence[BranchPoint]:
    """Points up to the first one in the window [rad/s]: that at its end, one a little inside, or those of a branch that
    begins outside and leads in. Off resonance the contacts bear less, and a first point is found where it is not at the
    end.

    raises: BranchStoppedError that says what stopped the attempt at the end itself
    """
    end, sign = (low, 1.0) if upwards else (high, -1.0)
    stopped: BranchStoppedError | None = None
    for share in (0.0, *stepper.options.outside):
        w = end - sign * share * (high - low)
        try:
            solution = first_point(stepper.system, excitation, w, stepper.options.persistent)
            start = point_at(solution, excitation, stepper.scale_w, (0 * solution.x, sign), 0.0)
            if share <= 0:
                return [start]
            if inside := _continued_into(stepper, start, low, high):
                return inside
        except BranchStoppedError as stop:
            stopped = stopped or stop
    assert stopped is not None, "the attempt at the end has returned or stopped"
    raise stopped


def _continued_into(stepper: PredictorCorrector, start: BranchPoint, low: float, high: float) -> Sequence[BranchPoint]:
    """From `start` into the window; none where the branch turns away from it."""
    traced, step = TracedBranch.through([start]), stepper.options.first_step
    away = max(low - start.w, start.w - high)
    for _ in range(stepper.options.max_points):
        points, step = stepper.next_points(traced, min(step, stepper.options.largest_step))
        traced, last = traced.extended(points), points[-1]
        if low <= last.w <= high:
            return traced.points
        if max(low - last.w, last.w - high) > away:
            break
    return []
