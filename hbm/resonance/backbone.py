"""Follow a resonance in the force, an iterator over solved points: peaks and backbones without response curves.

Pseudo-arclength continuation in (x / F, w, ln F), so that a resonance which turns back in force (an isolated branch, a
damper that lets go) is followed round. The metric is relative, as in hbm/continuation/continuation.py; a linear system
moves in ln F only, so that a step is about the logarithm of the force ratio from point to point.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.newton.newton import Status
from updamp.hbm.resonance.conditions import ResonanceCondition
from updamp.hbm.resonance.linear_peak import linear_peak
from updamp.hbm.resonance.resonance import (
    ResonanceProblem,
    ResonanceSolution,
    ResonanceState,
    constant_force_plane,
)
from updamp.hbm.resonance.resonance_predictor import (
    BranchOfResonances,
    FollowedResonance,
    RelativeMetric,
    ahead,
    difference,
)
from updamp.hbm.resonance.resonance_steps import (
    ResonanceOptions,
    ResonanceOutsideError,
    ResonanceSteps,
    ResonanceStoppedError,
)

Floats = NDArray[np.float64]


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


def first_resonance(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    window: tuple[float, float],
    force: float,
    options: ResonanceOptions | None = None,
    mode_frequency: float | None = None,
) -> ResonanceSolution:
    """The resonance at one force [N]: from the linear response's peak in `window` [Hz], by way of smaller forces where
    that is too far.

    mode_frequency: [Hz] of the linear mode, see `linear_peak`
    raises: ResonanceStoppedError, ResonanceOutsideError where what is found lies outside the window; ValueError where
        no mode lies in the window or the force is not positive
    """
    options, log_force = options or ResonanceOptions(), _log_force(force)
    peak = linear_peak(problem, window, log_force, mode_frequency)
    condition = condition.facing(peak.phase)
    lowest = log_force + np.log(options.lowest_start)
    while True:
        start = _resonance_near(problem, condition, replace(peak, log_force=log_force), options)
        # what converged outside the window is another mode's
        within = window[0] <= start.frequency <= window[1]
        if (start.converged and within) or log_force < lowest:
            break
        log_force -= np.log(10) / 2
    if not start.converged:
        raise ResonanceStoppedError(start, start.status)
    if not within:
        raise ResonanceOutsideError(start, window)
    if log_force == _log_force(force):
        return start
    (last,) = deque(_follow(problem, condition, start, [_log_force(force)], options.scale_w(window), options), maxlen=1)
    if not last.asked_for:
        raise ResonanceStoppedError(last.solution, Status.ENDED_BEFORE)
    return last.solution


def follow_resonance(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    window: tuple[float, float],
    forces: Sequence[float],
    options: ResonanceOptions | None = None,
    start: ResonanceState | None = None,
    mode_frequency: float | None = None,
) -> Iterator[ResonancePoint]:
    """Resonances from the first of `forces` to the last [N], rising or falling, each of them met exactly.

    window: [Hz] where the resonance lies at a small force; its width scales the metric
    start: a resonance near the first force, such as the peak of a response curve; default: `first_resonance`
    mode_frequency: [Hz] of the linear mode to begin with, see `linear_peak`

    raises: ResonanceStoppedError where the step would fall below its floor or no beginning is found;
    ValueError for no force, or forces that do not all rise or fall
    """
    options = options or ResonanceOptions()
    log_forces = [_log_force(force) for force in forces]
    if not log_forces or not ((np.diff(log_forces) > 0).all() or (np.diff(log_forces) < 0).all()):
        raise ValueError(
            f"forces = {list(forces)}: give one, or several that rise, or fall, from the first to the last"
        )
    condition = condition.facing((start or linear_peak(problem, window, log_forces[0], mode_frequency)).phase)
    if start is None:
        first = first_resonance(problem, condition, window, forces[0], options, mode_frequency)
    else:
        first = _resonance_near(problem, condition, replace(start, log_force=log_forces[0]), options)
        if not first.converged:
            raise ResonanceStoppedError(first, first.status)
    yield ResonancePoint(first, 0.0, False, True)
    if log_forces[1:]:
        yield from _follow(problem, condition, first, log_forces[1:], options.scale_w(window), options)


def _log_force(force: float) -> float:
    if not force > 0:
        raise ValueError(f"force = {force} N: a resonance needs a positive one")
    return float(np.log(force))


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
    upwards, metric = log_forces[-1] > first.state.log_force, RelativeMetric(problem.system.harmonics, scale_w)
    # a maximum has a phase of its own, and what is followed is the response at one phase
    first = condition.solve(problem, first.state, constant_force_plane(first.state), options.newton)
    if not first.converged:
        raise ResonanceStoppedError(first, first.status)
    branch = BranchOfResonances.from_force(metric, first, 1.0 if upwards else -1.0)
    steps, step = ResonanceSteps(problem, condition, branch, options), options.first_step
    followed = [FollowedResonance(first, branch.tangent(first.linearised, first.state), 0.0)]
    for _ in range(options.max_points - 1):
        asked_for = step
        point, step = steps.next_point(followed, step)
        solution, last = point.solution, followed[-1].state
        ends = followed[-1].solution, solution
        passed = log_forces_passed(log_forces, last.log_force, solution.state.log_force)
        try:
            met = [_at_log_force(problem, condition, ends, each, metric, options) for each in passed]
        except ResonanceStoppedError as stop:
            if stop.status is Status.NO_MAXIMUM or asked_for <= options.smallest_step:
                raise
            step = options.shortened(point.step)  # between points that are closer it is nearer to their chord
            continue
        for log_force, at_log_force in zip(passed, met, strict=True):
            yield ResonancePoint(at_log_force, metric.distance(last, at_log_force.state), False, True)
            if log_force == log_forces[-1]:
                return
        yield ResonancePoint(solution, point.step, _turns_back(followed, solution), False)
        if (solution.state.log_force > first.state.log_force) != upwards:
            return
        followed = [followed[-1], point]


def _turns_back(followed: Sequence[FollowedResonance], next_one: ResonanceSolution) -> bool:
    """Whether the force changes the other way after the last of them."""
    if len(followed) < 2:
        return False
    before, last = (one.state.log_force for one in followed[-2:])
    return (next_one.state.log_force - last) * (last - before) < 0


def log_forces_passed(log_forces: Sequence[float], here: float, there: float) -> list[float]:
    """Those of `log_forces` that lie beyond `here`, up to and including `there`, in the order of passing."""
    inside = [f for f in log_forces if min(here, there) <= f <= max(here, there) and f != here]
    return sorted(inside, reverse=bool(there < here))


def _at_log_force(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    ends: tuple[ResonanceSolution, ResonanceSolution],
    log_force: float,
    metric: RelativeMetric,
    options: ResonanceOptions,
) -> ResonanceSolution:
    """The resonance at exactly this force, between two that are known; what lies further from their chord than this is
    long is on another branch."""
    here, there = (end.state for end in ends)
    share = (log_force - here.log_force) / (there.log_force - here.log_force)
    between = replace(ahead(here, difference(there, here, 1.0), share), log_force=log_force)
    for guess in (between, replace(there, log_force=log_force), replace(here, log_force=log_force)):
        solution = condition.solve(problem, guess, constant_force_plane(guess), options.newton)
        if not solution.converged or metric.distance(between, solution.state) > metric.distance(here, there):
            continue
        solution = _resonance_near(problem, condition, solution.state, options)
        if solution.converged:
            return solution
        if solution.status is Status.NO_MAXIMUM:  # of the response at this force, wherever it is sought from
            break
    raise ResonanceStoppedError(solution, Status.OFF_BRANCH if solution.converged else solution.status)
