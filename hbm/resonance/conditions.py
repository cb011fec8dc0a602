"""What a resonance is: a phase, or the largest first harmonic at constant force.

The maximum (Raze, Volvert and Kerschen 2023 follow it by its own equation) is found here as the phase at which it
stands. Phase runs evenly through a resonance, turning points included, and no second derivative of the contact law is
needed, which sampled friction and separation do not have. For the same reason it is not followed from force to force:
where contacts change their states the place of the maximum jumps, the response at a given phase does not.
"""

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from updamp.hbm.continuation.step_lengths import StepLengths
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.resonance.resonance import (
    Hyperplane,
    ResonanceProblem,
    ResonanceSolution,
    ResonanceState,
    at_phase,
    constant_force_plane,
)

LARGEST_TURN = 0.4  # [rad] from one phase tried for the maximum to the next
HALF_POWER = np.pi / 4  # [rad] from a resonance's phase to those at which it has fallen to 1 / sqrt(2)


def turned(
    problem: ResonanceProblem, solution: ResonanceSolution, turn: float, options: NewtonOptions, lengths: StepLengths
) -> ResonanceSolution:
    """The response at the same force with its phase turned [rad], on the same branch: by less where the solution lies
    far off what the tangent at constant force has predicted, which may be another branch; its status tells where none
    on this branch is found."""
    state, line = solution.state, solution.linearised
    size = float(np.linalg.norm(state.z))  # the mean position counts: branches that vibrate alike differ in it
    while True:
        dw = turn / line.y_by_frequency.imag if line.y_by_frequency.imag else 0.0
        z = state.z - line.by_frequency * dw / np.exp(state.log_force)
        guess = replace(state, z=z, w=state.w + dw, phase=state.phase + turn)
        nearby = replace(problem, near=line.jacobian.factors)
        found = at_phase(nearby, guess, constant_force_plane(guess), options)
        off, moved = (float(np.linalg.norm(found.state.z - there.z)) / size for there in (guess, state))
        if found.converged and lengths.as_predicted(off, moved):
            return found
        if abs(turn) < lengths.smallest_step:
            return replace(found, status=Status.OFF_BRANCH) if found.converged else found
        turn /= 2


class ResonanceCondition(Protocol):
    """What is meant by resonance."""

    def facing(self, phase: float) -> "ResonanceCondition":
        """The same where the linear response at its largest has this phase [rad]: a point may move with the excitation
        or against it."""
        ...

    def solve(
        self, problem: ResonanceProblem, guess: ResonanceState, plane: Hyperplane, options: NewtonOptions
    ) -> ResonanceSolution:
        """What is followed, on `plane`; its status tells whether there is one nearby."""
        ...

    def at_force(self, problem: ResonanceProblem, guess: ResonanceState, options: NewtonOptions) -> ResonanceSolution:
        """The resonance at the guess's force; its status tells whether there is one nearby."""
        ...


@dataclass(frozen=True)
class PhaseResonance:
    """target: phase of the observed first harmonic against the force [rad].

    -pi/2 is a displacement a quarter period behind the force: the resonance of a single mode observed where it moves
    with its excitation. Where it moves against it, which the linear response tells, half a turn is added. With modes
    close together the maximum has another phase.
    """

    target: float = -np.pi / 2

    def facing(self, phase: float) -> "PhaseResonance":
        return self if np.cos(phase - self.target) >= 0 else PhaseResonance(self.target + np.pi)

    def solve(
        self, problem: ResonanceProblem, guess: ResonanceState, plane: Hyperplane, options: NewtonOptions
    ) -> ResonanceSolution:
        return at_phase(problem, replace(guess, phase=self.target), plane, options)

    def at_force(self, problem: ResonanceProblem, guess: ResonanceState, options: NewtonOptions) -> ResonanceSolution:
        return self.solve(problem, guess, constant_force_plane(guess), options)


@dataclass(frozen=True)
class MaximumResonance:
    """The largest first harmonic of the observed displacement along the response at constant force.

    From force to force the response is followed at one phase, and the maximum is looked for from there, along the
    response at constant force: up to the half-power points, where a resonance of that phase has fallen to 1 / sqrt(2).
    What is largest beyond them is not what is followed.

    tolerance: how near the phase comes to the maximum's [rad]; tries: phases tried at most
    followed: the phase that is followed [rad], by default that of the linear response at its maximum
    lengths: of the moves from phase to phase
    raises: ValueError for a tolerance that is not a small angle
    """

    tolerance: float = 1e-3
    tries: int = 100
    followed: float | None = None
    lengths: StepLengths = field(default_factory=StepLengths)

    def __post_init__(self) -> None:
        if not 1e-6 <= self.tolerance <= 0.1 or self.tries < 2:
            raise ValueError(f"tolerance = {self.tolerance} rad: between 1e-6 and 0.1; tries = {self.tries}: 2 or more")

    def facing(self, phase: float) -> "MaximumResonance":
        return self if self.followed is not None else replace(self, followed=phase)

    def solve(
        self, problem: ResonanceProblem, guess: ResonanceState, plane: Hyperplane, options: NewtonOptions
    ) -> ResonanceSolution:
        return at_phase(
            problem, guess if self.followed is None else replace(guess, phase=self.followed), plane, options
        )

    def at_force(self, problem: ResonanceProblem, guess: ResonanceState, options: NewtonOptions) -> ResonanceSolution:
        """Root of lag_to_maximum over the phase: secant steps kept inside the bracket once there is one.

        Sampled contact laws have tangents that jump, so there may be no root but a change of sign: the bracket is
        then closed to the tolerance, or as far as the response can be solved, and the largest that was is taken. What
        lies between no two phases of different sign is no maximum, and its status tells.
        """
        solution = self.solve(problem, guess, constant_force_plane(guess), options)
        tried = _PhaseBracket(solution.state.phase, self.lengths.most_growth)
        largest, iterations, status = solution, solution.iterations, Status.TOO_MANY_ITERATIONS
        for _ in range(self.tries):
            if not solution.converged:
                status = solution.status
                break
            if abs(solution.amplitude) > abs(largest.amplitude):
                largest = solution
            lag = solution.linearised.lag_to_maximum
            tried.add(solution.state.phase, lag)
            if abs(lag) < self.tolerance or tried.width < self.tolerance:
                return replace(solution, iterations=iterations)
            if tried.room < self.tolerance:
                status = Status.NO_MAXIMUM
                break
            solution = turned(problem, solution, tried.next() - solution.state.phase, options, self.lengths)
            iterations = max(iterations, solution.iterations)
        return replace(largest, iterations=iterations, status=Status.CONVERGED if tried.closed else status)


class _PhaseBracket:
    """Phases tried for the maximum: before it (lag > 0) and past it (lag < 0), within the half-power points of the
    phase that is followed [rad].

    growth: the most that a turn is longer than the last one, until a maximum is between two phases
    """

    def __init__(self, followed: float, growth: float) -> None:
        self.ends, self.growth = (followed - HALF_POWER, followed + HALF_POWER), growth
        self.before: tuple[float, float] | None = None
        self.past: tuple[float, float] | None = None
        self.last: list[tuple[float, float]] = []
        self.widths: list[float] = []

    @property
    def closed(self) -> bool:
        """Whether a maximum lies between two phases tried."""
        return self.before is not None and self.past is not None

    @property
    def width(self) -> float:
        return self.before[0] - self.past[0] if self.before and self.past else np.inf

    @property
    def room(self) -> float:
        """From the last phase to the half-power point that lies towards the maximum, where none is between two phases
        [rad]."""
        phase, lag = self.last[-1]
        return np.inf if self.closed else abs(self.ends[0 if lag > 0 else 1] - phase)

    def add(self, phase: float, lag: float) -> None:
        if lag > 0 and (self.before is None or phase < self.before[0]):
            self.before = (phase, lag)
        if lag <= 0 and (self.past is None or phase > self.past[0]):
            self.past = (phase, lag)
        self.last = [*self.last[-1:], (phase, lag)]
        self.widths = [*self.widths[-1:], self.width]

    def next(self) -> float:
        (phase, lag), before = self.last[-1], self.last[0][0]
        turn, longest = -lag, LARGEST_TURN
        if phase != before:
            slope = (lag - self.last[0][1]) / (phase - before)
            turn = -lag / slope if slope > 0 else -np.sign(lag) * np.inf
            longest = LARGEST_TURN if self.closed else min(self.growth * abs(phase - before), LARGEST_TURN)
        proposed = float(np.clip(phase + np.clip(turn, -longest, longest), *self.ends))
        if self.before and self.past:
            halved = self.width <= self.widths[0] / 2
            if not (halved and self.past[0] < proposed < self.before[0]):
                return (self.past[0] + self.before[0]) / 2
        return proposed
