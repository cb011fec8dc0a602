"""Follow a resonance in the force, an iterator over solved points: peaks and backbones without response curves.

Pseudo-arclength continuation in (x / F, w, ln F), so that a resonance which turns back in force (an isolated branch, a
damper that lets go) is followed round. The metric is relative, as in hbm/continuation/continuation.py; a linear system
moves in ln F only, so that a step is about the logarithm of the force ratio from point to point.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.resonance.conditions import ResonanceCondition, linear_peak
from updamp.hbm.resonance.resonance import (
    Hyperplane,
    ResonanceProblem,
    ResonanceSolution,
    ResonanceState,
    constant_frequency_plane,
)
from updamp.hbm.resonance.resonance_predictor import RelativeMetric, ahead, difference, predict, size_of

Floats = NDArray[np.float64]

# Beyond a kink, how far the response may have moved: an ordinary step at its largest.
_FURTHEST_BEYOND = 0.4


@dataclass(frozen=True)
class ResonanceOptions:
    """Steps are lengths of arc in the relative metric, about ln of a force ratio.

    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    beyond_kinks: where no smaller step is solved, resonances at frequencies so far ahead are tried, at whatever force,
        in units of arc: where contacts change their states the frequency goes on evenly and the force need not
    max_points: at most this many points; lowest_start: the force may be lowered to this share of the first force to
    find a beginning

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.1
    smallest_step: float = 1e-4
    largest_step: float = 0.4
    wanted_iterations: int = 5
    frequency_scale: float = 0.5
    beyond_kinks: tuple[float, ...] = (1e-4, 3e-4, 1e-3, 3e-3, 0.01)
    max_points: int = 1000
    lowest_start: float = 1e-6
    newton: NewtonOptions = field(default_factory=NewtonOptions)

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step < self.first_step <= self.largest_step:
            raise ValueError(
                f"steps {self.smallest_step}, {self.first_step}, {self.largest_step}: "
                "0 < smallest_step < first_step <= largest_step is needed"
            )
        if self.frequency_scale <= 0 or self.max_points < 2 or not 0 < self.lowest_start < 1:
            raise ValueError(
                f"frequency_scale = {self.frequency_scale} must be positive, max_points = {self.max_points} at least "
                f"2 and lowest_start = {self.lowest_start} between 0 and 1"
            )


@dataclass(frozen=True, eq=False)
class ResonancePoint:
    """step: arc length from the point before; turning: whether the force turned round since then; asked_for: whether
    the force is one of those asked for"""

    solution: ResonanceSolution
    step: float
    turning: bool
    asked_for: bool

    @property
    def force(self) -> float:
        """[N]"""
        return self.solution.force

    @property
    def frequency(self) -> float:
        """[Hz]"""
        return self.solution.frequency

    @property
    def receptance(self) -> complex:
        """First harmonic of the observed displacement over the force [m/N]."""
        return self.solution.amplitude / self.solution.force


class ResonanceStoppedError(Exception):
    """A resonance that cannot be followed on. What was computed has been handed out already."""

    def __init__(self, solution: ResonanceSolution, status: Status) -> None:
        self.force, self.frequency, self.status, self.error = solution.force, solution.frequency, status, solution.error
        super().__init__(
            f"the resonance stops at {self.force:.4g} N, {self.frequency:.4f} Hz: {status.value}, residual "
            f"{self.error:.1e} of the displacement; {status.advice}, or begin at another force or response curve"
        )


def first_resonance(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    window: tuple[float, float],
    force: float,
    options: ResonanceOptions | None = None,
) -> ResonanceSolution:
    """The resonance at one force [N]: from the stuck structure's peak in `window` [Hz], by way of smaller forces where
    that is too far.

    raises: ResonanceStoppedError; ValueError where no stuck mode lies in the window or the force is not positive
    """
    options, log_force = options or ResonanceOptions(), _log_force(force)
    peak = linear_peak(problem, window, log_force)
    condition = condition.facing(peak.phase)
    lowest = log_force + np.log(options.lowest_start)
    while True:
        start = _resonance_near(problem, condition, replace(peak, log_force=log_force), options)
        # what converged outside the window is another mode's
        within = window[0] <= start.frequency <= window[1]
        if (start.converged and within) or log_force < lowest:
            break
        log_force -= np.log(10) / 2
    if not (start.converged and within):
        raise ResonanceStoppedError(start, Status.STALLED if start.converged else start.status)
    if log_force == _log_force(force):
        return start
    *_, last = _follow(problem, condition, start, [_log_force(force)], _scale_w(window, options), options)
    if not last.asked_for:
        raise ResonanceStoppedError(last.solution, Status.STALLED)
    return last.solution


def follow_resonance(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    window: tuple[float, float],
    forces: Sequence[float],
    options: ResonanceOptions | None = None,
    start: ResonanceState | None = None,
) -> Iterator[ResonancePoint]:
    """Resonances from the first of `forces` to the last [N], rising or falling, each of them met exactly.

    window: [Hz] where the stuck structure's resonance lies; its width scales the metric
    start: a resonance near the first force, such as the peak of a response curve; default: `first_resonance`

    raises: ResonanceStoppedError where the step would fall below its floor or no beginning is found;
    ValueError for no force, or forces that do not all rise or fall
    """
    options = options or ResonanceOptions()
    log_forces = [_log_force(force) for force in forces]
    if not log_forces or not ((np.diff(log_forces) > 0).all() or (np.diff(log_forces) < 0).all()):
        raise ValueError(
            f"forces = {list(forces)}: give one, or several that rise, or fall, from the first to the last"
        )
    condition = condition.facing((start or linear_peak(problem, window, log_forces[0])).phase)
    if start is None:
        first = first_resonance(problem, condition, window, forces[0], options)
    else:
        first = _resonance_near(problem, condition, replace(start, log_force=log_forces[0]), options)
        if not first.converged:
            raise ResonanceStoppedError(first, first.status)
    yield ResonancePoint(first, 0.0, False, True)
    if log_forces[1:]:
        yield from _follow(problem, condition, first, log_forces[1:], _scale_w(window, options), options)


def _log_force(force: float) -> float:
    if not force > 0:
        raise ValueError(f"force = {force} N: a resonance needs a positive one")
    return float(np.log(force))


def _scale_w(window: tuple[float, float], options: ResonanceOptions) -> float:
    return 2 * np.pi * options.frequency_scale * (window[1] - window[0])


def _resonance_near(
    problem: ResonanceProblem, condition: ResonanceCondition, guess: ResonanceState, options: ResonanceOptions
) -> ResonanceSolution:
    return condition.at_force(problem, guess, options.newton)


def _follow(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    first: ResonanceSolution,
    log_forces: Sequence[float],
    scale_w: float,
    options: ResonanceOptions,
) -> Iterator[ResonancePoint]:
    upwards = log_forces[-1] > first.state.log_force
    metric = RelativeMetric(scale_w)
    followed, step, direction = [first], options.first_step, 1.0 if upwards else -1.0
    for _ in range(options.max_points - 1):
        solution, moved, step_next = _next(problem, condition, followed, step, direction, metric, options)
        last = followed[-1].state
        for log_force in log_forces_passed(log_forces, last.log_force, solution.state.log_force):
            at_log_force = _at_log_force(problem, condition, (followed[-1], solution), log_force, options)
            yield ResonancePoint(at_log_force, metric.distance(last, at_log_force.state), False, True)
            if log_force == log_forces[-1]:
                return
        turning = (
            len(followed) > 1
            and (solution.state.log_force - last.log_force) * (last.log_force - followed[-2].state.log_force) < 0
        )
        yield ResonancePoint(solution, moved, turning, False)
        if (solution.state.log_force > first.state.log_force) != upwards:
            return
        kept = 2 if moved < 2 * step else 1  # beyond a kink what lies before the last point says nothing
        followed, step = [*followed[-kept:], solution], step_next


def _next(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    followed: Sequence[ResonanceSolution],
    step: float,
    direction: float,
    metric: RelativeMetric,
    options: ResonanceOptions,
) -> tuple[ResonanceSolution, float, float]:
    """The following resonance, its distance, and the step to try after it; the step is halved until one is found."""
    last = followed[-1].state
    while True:
        normal, guess = predict(followed, step, direction, metric)
        plane = Hyperplane(guess, normal, size_of(last), metric.scale_w)
        solution = condition.solve(problem, guess, plane, options.newton)
        moved = metric.distance(last, solution.state)
        if solution.converged and moved < 2 * step:
            break
        if step / 2 < options.smallest_step:
            return _beyond_kink(problem, condition, followed, solution.status, metric, options)
        step /= 2
    growth = np.clip(2.0 ** ((options.wanted_iterations - solution.iterations) / 2), 0.5, 2.0)
    return solution, moved, float(np.clip(step * growth, options.smallest_step, options.largest_step))


def _beyond_kink(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    followed: Sequence[ResonanceSolution],
    status: Status,
    metric: RelativeMetric,
    options: ResonanceOptions,
) -> tuple[ResonanceSolution, float, float]:
    """As `_next`, at a frequency a little ahead: on the side to which it has moved, or on the other one.

    raises: ResonanceStoppedError where none is found
    """
    last, before = followed[-1].state, followed[-2].state if len(followed) > 1 else followed[-1].state
    sign = float(np.sign(last.w - before.w)) or -1.0
    for share in (side * length for length in options.beyond_kinks for side in (sign, -sign)):
        guess = replace(last, w=last.w + share * metric.scale_w)
        solution = condition.solve(problem, guess, constant_frequency_plane(guess), options.newton)
        moved = metric.distance(last, solution.state)
        # further from the point before than from the last one: what turns sharper than that may lead back
        if solution.converged and moved < _FURTHEST_BEYOND and metric.distance(before, solution.state) > moved:
            return solution, moved, max(options.first_step * moved, options.smallest_step)
    raise ResonanceStoppedError(followed[-1], Status.STALLED if status is Status.CONVERGED else status)


def log_forces_passed(log_forces: Sequence[float], here: float, there: float) -> list[float]:
    """Those of `log_forces` that lie beyond `here`, up to and including `there`, in the order of passing."""
    inside = [f for f in log_forces if min(here, there) <= f <= max(here, there) and f != here]
    return sorted(inside, reverse=bool(there < here))


def _at_log_force(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    ends: tuple[ResonanceSolution, ResonanceSolution],
    log_force: float,
    options: ResonanceOptions,
) -> ResonanceSolution:
    """The resonance at exactly this force, between two that are known."""
    here, there = (end.state for end in ends)
    share = (log_force - here.log_force) / (there.log_force - here.log_force)
    between = replace(ahead(here, difference(there, here, 1.0), share), log_force=log_force)
    for guess in (between, replace(there, log_force=log_force), replace(here, log_force=log_force)):
        solution = _resonance_near(problem, condition, guess, options)
        if solution.converged:
            return solution
    raise ResonanceStoppedError(solution, solution.status)
