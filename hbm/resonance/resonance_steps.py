"""Steps along a branch of resonances: predicted along its tangent, corrected on the plane across it, and refused where
they have ended elsewhere than the branch goes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import scipy.linalg

from updamp.hbm.continuation.step_lengths import StepLengths
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.resonance.conditions import ResonanceCondition
from updamp.hbm.resonance.resonance import (
    Hyperplane,
    ResonanceProblem,
    ResonanceSolution,
    ResonanceState,
    linearised_at,
)
from updamp.hbm.resonance.resonance_predictor import (
    BranchOfResonances,
    FollowedResonance,
    ahead,
    difference,
    predict,
)


@dataclass(frozen=True)
class ResonanceOptions(StepLengths):
    """Steps are of about ln of a force ratio.

    straight: a step counts where the tangents at both its ends go its way, by the cosine of their angles to it at
        least: what does not is another branch, or the same one on its way back
    smallest_step: as the first of `beyond_kinks`; shorter ones, as curves take them, have not been tried
    beyond_kinks: where no smaller step is solved contacts change their states: so far ahead [arc] the tangent of the
        branch beyond is taken, and steps of the lengths after the kink are tried along it
    off_predicted: wider than a curve's: with 0.3, 0.2 and 0.1 the same resonance was met (benchmarks/harmonic_balance/
        NOTES.md)
    max_points: at most this many points; lowest_start: the force may be lowered to this share of the first force to
    find a beginning

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.1
    smallest_step: float = 1e-4
    largest_step: float = 0.4
    wanted_iterations: int = 5
    off_predicted: float = 0.1
    straight: float = 0.5
    beyond_kinks: tuple[float, ...] = (1e-4, 3e-4, 1e-3, 3e-3, 0.01)
    max_points: int = 1000
    lowest_start: float = 1e-6
    newton: NewtonOptions = field(default_factory=NewtonOptions)
    corrector: NewtonOptions = field(default_factory=lambda: NewtonOptions(iterations=8, damped=False, patience=5))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_points < 2 or not 0 < self.lowest_start < 1:
            raise ValueError(
                f"max_points = {self.max_points} must be at least 2 and lowest_start = {self.lowest_start} between 0 "
                "and 1"
            )


class ResonanceStoppedError(RuntimeError):
    """A resonance that cannot be followed on. What was computed has been handed out already."""

    def __init__(self, solution: ResonanceSolution, status: Status) -> None:
        self.force, self.frequency, self.status, self.error = solution.force, solution.frequency, status, solution.error
        where = f"the resonance stops at {self.force:.4g} N, {self.frequency:.6g} Hz: {status.value}"
        # The point is, and is not what is looked for.
        solved = status in (Status.NO_MAXIMUM, Status.OFF_BRANCH, Status.ENDED_BEFORE)
        super().__init__(
            f"{where}; {status.advice}"
            if solved
            else f"{where}, residual {self.error:.1e} of the displacement; {status.advice}, or begin at another force "
            "or response curve"
        )


class ResonanceOutsideError(ResonanceStoppedError):
    """A beginning that is solved, and lies outside the window [Hz]: another mode's."""

    def __init__(self, solution: ResonanceSolution, window: tuple[float, float]) -> None:
        super().__init__(solution, solution.status)
        self.args = (
            f"the resonance that is found at {self.force:.4g} N lies at {self.frequency:.6g} Hz, outside the window "
            f"from {window[0]:g} to {window[1]:g} Hz: widen the window so that it holds it, give a `start` inside, "
            "such as the peak of a response curve, or another condition",
        )


@dataclass(frozen=True, eq=False)
class ResonanceSteps:
    """Finds the resonance that follows those so far."""

    problem: ResonanceProblem
    condition: ResonanceCondition
    branch: BranchOfResonances
    options: ResonanceOptions

    def next_point(self, followed: Sequence[FollowedResonance], step: float) -> tuple[FollowedResonance, float]:
        """The following resonance and the step to try after it.

        raises: ResonanceStoppedError
        """
        options, last, asked_for = self.options, followed[-1], step
        while True:
            guess = predict(followed, step, self.branch.metric, options)
            point, solution = self._corrected(last, guess, last.tangent, step)
            if point is not None:
                return point, options.following(step, point.step, solution.iterations, step < asked_for)
            if step <= options.smallest_step:
                break
            step = options.shortened(step)
        for there, tangent in self._beyond_kink(last):
            for length in options.beyond_kinks:
                point, _ = self._corrected(last, ahead(there, tangent, length), tangent, length)
                if point is not None:
                    return point, max(length, options.smallest_step)
        status = Status.OFF_BRANCH if solution.status is Status.CONVERGED else solution.status
        raise ResonanceStoppedError(last.solution, status)

    def _corrected(
        self, last: FollowedResonance, guess: ResonanceState, normal: ResonanceState, step: float
    ) -> tuple[FollowedResonance | None, ResonanceSolution]:
        metric = self.branch.metric
        plane = Hyperplane(guess, normal, metric.on_curve(last.state))
        nearby = replace(self.problem, near=last.solution.linearised.jacobian.factors)
        solution = self.condition.solve(nearby, guess, plane, self.options.corrector)
        if not solution.converged:
            return None, solution
        moved = metric.distance(last.state, solution.state)
        off = metric.distance(guess, solution.state)
        if not (self.options.counts(moved, step) and self.options.as_predicted(off, moved)):
            return None, solution
        tangent = self.branch.tangent(solution.linearised, solution.state)
        way = difference(solution.state, last.state, 1 / moved)
        straight = min(metric.product(last.state, way, end) for end in (normal, tangent)) > self.options.straight
        return FollowedResonance(solution, tangent, moved) if straight else None, solution

    def _beyond_kink(self, last: FollowedResonance) -> Iterator[tuple[ResonanceState, ResonanceState]]:
        """Places a little ahead, where contacts have other states, and the tangents of the branch as it is there. From
        a place before the kink Newton's method leads back to the branch that came there."""
        for length in self.options.beyond_kinks:
            there = ahead(last.state, last.tangent, length)
            try:
                yield there, self.branch.tangent(linearised_at(self.problem, there), there)
            except scipy.linalg.LinAlgError:
                continue
