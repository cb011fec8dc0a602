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
from updamp.hbm.resonance.resonance import Place, Plane, ResonanceProblem, ResonanceSolution, constant_force

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ResonanceOptions:
    """Steps are lengths of arc in the relative metric, about ln of a force ratio.

    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    frequency_scale: share of the window that counts as one unit of arc
    max_points: at most this many points; lowest_start: the force may be lowered to this share of the first force to
    find a beginning

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.1
    smallest_step: float = 1e-4
    largest_step: float = 0.4
    wanted_iterations: int = 5
    frequency_scale: float = 0.5
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
    options = options or ResonanceOptions()
    level = _level(force)
    lowest = level + np.log(options.lowest_start)
    while True:
        start = _resonance_near(problem, condition, linear_peak(problem, window, level), options)
        if start.converged or level < lowest:
            break
        level -= np.log(10) / 2
    if not start.converged:
        raise ResonanceStoppedError(start, start.status)
    if level == _level(force):
        return start
    *_, last = _follow(problem, condition, start, [_level(force)], _scale_w(window, options), options)
    if not last.asked_for:
        raise ResonanceStoppedError(last.solution, Status.STALLED)
    return last.solution


def follow_resonance(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    window: tuple[float, float],
    forces: Sequence[float],
    options: ResonanceOptions | None = None,
    start: Place | None = None,
) -> Iterator[ResonancePoint]:
    """Resonances from the first of `forces` to the last [N], rising or falling, each of them met exactly.

    window: [Hz] where the stuck structure's resonance lies; its width scales the metric
    start: a resonance near the first force, such as the peak of a response curve; default: `first_resonance`

    raises: ResonanceStoppedError where the step would fall below its floor or no beginning is found;
    ValueError for no force, or forces that do not all rise or fall
    """
    options = options or ResonanceOptions()
    levels = [_level(force) for force in forces]
    if not levels or not ((np.diff(levels) > 0).all() or (np.diff(levels) < 0).all()):
        raise ValueError(
            f"forces = {list(forces)}: give one, or several that rise, or fall, from the first to the last"
        )
    if start is None:
        first = first_resonance(problem, condition, window, forces[0], options)
    else:
        first = _resonance_near(problem, condition, replace(start, level=levels[0]), options)
        if not first.converged:
            raise ResonanceStoppedError(first, first.status)
    yield ResonancePoint(first, 0.0, False, True)
    if levels[1:]:
        yield from _follow(problem, condition, first, levels[1:], _scale_w(window, options), options)


def _level(force: float) -> float:
    if not force > 0:
        raise ValueError(f"force = {force} N: a resonance needs a positive one")
    return float(np.log(force))


def _scale_w(window: tuple[float, float], options: ResonanceOptions) -> float:
    return 2 * np.pi * options.frequency_scale * (window[1] - window[0])


def _resonance_near(
    problem: ResonanceProblem, condition: ResonanceCondition, guess: Place, options: ResonanceOptions
) -> ResonanceSolution:
    return condition.settle(problem, guess, constant_force(guess), options.newton)


def _follow(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    first: ResonanceSolution,
    levels: Sequence[float],
    scale_w: float,
    options: ResonanceOptions,
) -> Iterator[ResonancePoint]:
    upwards = levels[-1] > first.place.level
    metric = _Metric(scale_w)
    passed, step, direction = [first], options.first_step, 1.0 if upwards else -1.0
    for _ in range(options.max_points - 1):
        solution, moved, step_next = _next(problem, condition, passed, step, direction, metric, options)
        last = passed[-1].place
        for level in levels_passed(levels, last.level, solution.place.level):
            landed = _land(problem, condition, (passed[-1], solution), level, options)
            yield ResonancePoint(landed, metric.distance(last, landed.place), False, True)
            if level == levels[-1]:
                return
        turning = len(passed) > 1 and (solution.place.level - last.level) * (last.level - passed[-2].place.level) < 0
        yield ResonancePoint(solution, moved, turning, False)
        if (solution.place.level > first.place.level) != upwards:
            return
        passed, step = [*passed[-2:], solution], step_next


@dataclass(frozen=True)
class _Metric:
    scale_w: float

    def distance(self, here: Place, there: Place) -> float:
        dz, dw, dlevel = there.z - here.z, there.w - here.w, there.level - here.level
        return float(np.sqrt(np.sum(dz**2) / _size(here) ** 2 + (dw / self.scale_w) ** 2 + dlevel**2))

    def unit(self, here: Place, towards: Place) -> Place:
        length = np.sqrt(np.sum(towards.z**2) / _size(here) ** 2 + (towards.w / self.scale_w) ** 2 + towards.level**2)
        return Place(*(part / length for part in (towards.z, towards.w, towards.level, towards.phase)))


def _size(place: Place) -> float:
    return max(float(np.linalg.norm(place.z)), np.finfo(float).tiny)


def _next(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    passed: Sequence[ResonanceSolution],
    step: float,
    direction: float,
    metric: _Metric,
    options: ResonanceOptions,
) -> tuple[ResonanceSolution, float, float]:
    """The following resonance, its distance, and the step to try after it; the step is halved until one is found."""
    last = passed[-1].place
    while True:
        normal, guess = _predict(passed, step, direction, metric)
        plane = Plane(guess, normal, _size(last), metric.scale_w)
        solution = condition.settle(problem, guess, plane, options.newton)
        moved = metric.distance(last, solution.place)
        if solution.converged and moved < 2 * step:
            break
        if step / 2 < options.smallest_step:
            raise ResonanceStoppedError(passed[-1], Status.STALLED if solution.converged else solution.status)
        step /= 2
    growth = np.clip(2.0 ** ((options.wanted_iterations - solution.iterations) / 2), 0.5, 2.0)
    return solution, moved, float(np.clip(step * growth, options.smallest_step, options.largest_step))


def _predict(
    passed: Sequence[ResonanceSolution], step: float, direction: float, metric: _Metric
) -> tuple[Place, Place]:
    """Direction of the branch and the place `step` further: a parabola through the last three points, a line through
    two, and from one the tangent of constant phase."""
    last = passed[-1].place
    if len(passed) == 1:
        normal = metric.unit(last, _tangent(passed[0], direction))
        return normal, _ahead(last, normal, step)
    before = passed[-2].place
    distance = metric.distance(before, last)
    secant = _difference(last, before, 1 / distance)
    rate = secant
    if len(passed) > 2:
        earlier = passed[-3].place
        gap = metric.distance(earlier, before)
        bend = _difference(secant, _difference(before, earlier, 1 / gap), 1 / (distance + gap))
        rate = _ahead(secant, bend, step + distance)
    return metric.unit(last, secant), _ahead(last, rate, step)


def _tangent(solution: ResonanceSolution, direction: float) -> Place:
    """d(z, w, ln F) along the branch of constant phase, ln F moving in `direction`."""
    line, place = solution.linearised, solution.place
    dw = -direction * line.log_level.imag / line.log_frequency.imag
    dx = -line.by_frequency * dw - line.by_level * direction
    return Place(dx / solution.force - place.z * direction, dw, direction, 0.0)


def _ahead(place: Place, rate: Place, step: float) -> Place:
    return Place(
        place.z + step * rate.z,
        place.w + step * rate.w,
        place.level + step * rate.level,
        place.phase + step * rate.phase,
    )


def _difference(a: Place, b: Place, factor: float) -> Place:
    return Place(factor * (a.z - b.z), factor * (a.w - b.w), factor * (a.level - b.level), factor * (a.phase - b.phase))


def levels_passed(levels: Sequence[float], here: float, there: float) -> list[float]:
    """Those of `levels` that lie beyond `here`, up to and including `there`, in the order of passing."""
    inside = [level for level in levels if min(here, there) <= level <= max(here, there) and level != here]
    return sorted(inside, reverse=bool(there < here))


def _land(
    problem: ResonanceProblem,
    condition: ResonanceCondition,
    ends: tuple[ResonanceSolution, ResonanceSolution],
    level: float,
    options: ResonanceOptions,
) -> ResonanceSolution:
    """The resonance at exactly this level, between two that are known."""
    here, there = (end.place for end in ends)
    share = (level - here.level) / (there.level - here.level)
    between = replace(_ahead(here, _difference(there, here, 1.0), share), level=level)
    for guess in (between, replace(there, level=level), replace(here, level=level)):
        solution = _resonance_near(problem, condition, guess, options)
        if solution.converged:
            return solution
    raise ResonanceStoppedError(solution, solution.status)
