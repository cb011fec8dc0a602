"""Pseudo-arclength continuation of a response branch in frequency, as an iterator over solved points."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, other_way_round, point_at
from updamp.hbm.continuation.first_point import first_point
from updamp.hbm.continuation.predictor_corrector import BranchStoppedError, ContinuationOptions, PredictorCorrector
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.newton import Solution
from updamp.hbm.problem.system import Excitation, NonlinearSystem

__all__ = ["BranchStoppedError", "ContinuationOptions", "continue_branch", "first_point"]


def continue_branch(
    system: NonlinearSystem,
    excitation: Excitation,
    window: tuple[float, float],
    options: ContinuationOptions | None = None,
    upwards: bool = True,
    resume_from: Sequence[BranchPoint] = (),
    from_outside: float | None = None,
) -> Iterator[BranchPoint]:
    """Points of the branch through `window` [Hz], from its lower end (or upper: upwards=False) until it leaves it.

    resume_from: the last points of an interrupted branch; the first point handed out is the one that follows
    from_outside: a frequency [Hz] on that side of the window where there is one response: the branch that comes in from
        there is wanted, of several where the window ends inside a hysteresis. Where none comes in, one at the end is

    raises: BranchStoppedError where the step would fall below its floor
    """
    options = options or ContinuationOptions()
    stepper = PredictorCorrector(system, excitation, options, options.scale_w(window))
    low, high = (2 * np.pi * f for f in window)
    shares = *_beyond(window, upwards, from_outside), 0.0, *options.outside
    points = list(resume_from) or _first_points(stepper, excitation, low, high, upwards, shares)
    traced = TracedBranch.through(points)
    yield from points[len(resume_from) :]
    handed_out = len(points)
    step = max(traced.last.step, options.first_step) if len(traced.points) > 1 else options.first_step
    while handed_out < options.max_points:
        points, step = stepper.next_points(traced, min(step, options.largest_step))
        yield from points
        handed_out += len(points)
        traced = traced.extended(points)
        if not low <= traced.last.w <= high:
            return


def _beyond(window: tuple[float, float], upwards: bool, frequency: float | None) -> tuple[float, ...]:
    """How far that lies beyond the end at which a branch begins, in shares of the window; none where it does not."""
    if frequency is None:
        return ()
    low, high = window
    share = (low - frequency if upwards else frequency - high) / (high - low)
    return (share,) if share > 0 else ()


def _first_points(
    stepper: PredictorCorrector,
    excitation: Excitation,
    low: float,
    high: float,
    upwards: bool,
    shares: Sequence[float],
) -> Sequence[BranchPoint]:
    """Points from the window's end [rad/s] on: one at it, or those of a branch that begins outside and leads in, or
    inside and leads out. Off resonance the contacts bear less, and a first point is found where it is not at the end.

    shares: how far beyond the end to begin, in shares of the window, the first that leads in

    raises: BranchStoppedError that says what stopped the attempt at the end itself
    """
    end, sign = (low, 1.0) if upwards else (high, -1.0)
    stopped: BranchStoppedError | None = None
    for share in shares:
        w = end - sign * share * (high - low)
        try:
            solution = first_point(stepper.system, excitation, w, stepper.options.persistent)
        except BranchStoppedError as stop:
            stopped = stopped or stop
            continue
        if share > 0:
            if led := _led_in(stepper, excitation, solution, low, high):
                return led
        else:
            start = point_at(solution, excitation, stepper.scale_w, (0 * solution.x, -sign), 0.0)
            led = _until(stepper, start, lambda w: not low < w < high) if share else [start]
            return other_way_round(led or [start])
    assert stopped is not None, "the attempt at the end has returned or stopped"
    raise stopped


def _led_in(
    stepper: PredictorCorrector, excitation: Excitation, solution: Solution, low: float, high: float
) -> Sequence[BranchPoint]:
    """From a solution outside the window [rad/s] to the last point before it and the first one inside; none where the
    branch does not lead in. Far from a narrow window steps are as long as the way that is left allows, and shorter the
    nearer it is."""
    end, sign = (low, 1.0) if solution.w < low else (high, -1.0)
    direction = 0 * solution.x, sign
    while True:
        width = max(abs(end - solution.w), high - low)
        scale_w = stepper.options.frequency_scale * width
        start = point_at(solution, excitation, scale_w, direction, 0.0)
        led = _until(replace(stepper, scale_w=scale_w), start, lambda w: sign * (w - end) >= 0)
        if not led:
            return []
        before, last = led[-2:]
        if width == high - low:
            return [before, last] if low <= last.w <= high else []
        if before is start:
            return []
        solution, direction = before.solution, before.tangent


def _until(
    stepper: PredictorCorrector,
    start: BranchPoint,
    there: Callable[[float], bool],
) -> Sequence[BranchPoint]:
    """From `start` on until `there` is true of the angular frequency; none where the branch stops or turns away."""
    traced, step, points = TracedBranch.through([start]), stepper.options.first_step, [start]
    for _ in range(stepper.options.max_points):
        try:
            found, step = stepper.next_points(traced, min(step, stepper.options.largest_step))
        except BranchStoppedError:
            return []
        traced, points = traced.extended(found), [*points, *found]
        if there(points[-1].w):
            return points
        if (points[-1].w - start.w) * start.tangent_w < 0:
            return []
    return []
