"""Newton's method on the harmonic balance residual, at fixed frequency or along an arc."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import cast

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton.active_forces import DirectForces
from updamp.hbm.newton.equation import Equation, evaluate, evaluate_together, residual_alone
from updamp.hbm.newton.jacobian import Jacobian
from updamp.hbm.newton.metric import Metric, Move
from updamp.hbm.problem.system import Forcing, NonlinearSystem

Floats = NDArray[np.float64]


class Status(Enum):
    """What became of a solution; `advice` says what to try."""

    CONVERGED = "converged"
    TOO_MANY_ITERATIONS = "too many iterations"
    DIVERGED = "diverged"
    STALLED = "stalled"
    OFF_BRANCH = "solved, but off the branch"
    ENDED_BEFORE = "ended before the force asked for"
    NO_MAXIMUM = "no maximum of the response between the half-power points of the phase that is followed"

    @property
    def advice(self) -> str:
        return _ADVICE[self]


_ADVICE = {
    Status.CONVERGED: "",
    Status.TOO_MANY_ITERATIONS: "start closer (smaller step, neighbouring force level) or allow more iterations",
    Status.DIVERGED: "the residual is not finite: check stiffness, preload, the zero harmonic's support by the wire, "
    "and laws of your own at large motions (a root or a logarithm of what may be negative there)",
    Status.STALLED: "no step lowers the residual: use more time samples, or start from fewer harmonics",
    Status.OFF_BRANCH: "each step ended elsewhere: another branch crosses or lies close by, as where equal parts move "
    "alike; let these differ a little, in their stiffness by 1e-3",
    Status.ENDED_BEFORE: "the resonance turns back in force, or takes more points than `max_points` allows: trace the "
    "response curve at the force asked for",
    Status.NO_MAXIMUM: "trace the response curve at this force",
}


@dataclass(frozen=True)
class NewtonOptions:
    """tolerance: largest residual over the displacement (`Equation.size`); iterations: at most this many.
    smallest_damping: shortest part of a step that is tried
    memory: a residual may exceed the last one, but not all of this many
    damped: whether steps are shortened at all. Across a kink the full step solves the far side's equations, however
        much the residual rises on the way; a shortened one stays at the kink. For starts close to a solution.
    patience: given up where after so many iterations the residual is not below `PROGRESS` of the first; None: never

    raises: ValueError naming the option that is out of range
    """

    tolerance: float = 1e-9
    iterations: int = 12
    smallest_damping: float = 1 / 64
    memory: int = 4
    damped: bool = True
    patience: int | None = None

    def __post_init__(self) -> None:
        if not 1e-14 < self.tolerance < 1e-2:
            raise ValueError(f"tolerance = {self.tolerance}: allowed between 1e-14 and 1e-2")
        if self.iterations < 1:
            raise ValueError(f"iterations = {self.iterations}: at least 1")
        if self.patience is not None and self.patience < 1:
            raise ValueError(f"patience = {self.patience}: at least 1, or None")

    @property
    def lowering(self) -> "NewtonOptions":
        """The same, but that each step lowers the residual, as long as one does."""
        return replace(self, damped=True, memory=1, patience=None)

    def out_of_patience(self, errors: Sequence[float]) -> bool:
        """errors: of all iterates so far"""
        return len(errors) - 1 == self.patience and errors[-1] > PROGRESS * errors[0]


# What a corrector that will converge leaves of the first residual after its patience. Of 2,228 that did converge on the
# stress grid 17 had not come so far after four iterations and 2 after five; of 872 that did not, all but 87 and 105.
PROGRESS = 0.3


@dataclass(frozen=True, eq=False)
class Solution:
    """x: (n_relative, n_coefficients) [m]; w [rad/s]; errors: as in Equation, one entry an iteration

    jacobian: at the iterate before the last; by_frequency: its J^-1 dr/dw [m s], None at fixed frequency
    """

    x: Floats
    w: float
    status: Status
    iterations: int
    errors: tuple[float, ...]
    equation: Equation
    jacobian: Jacobian | None
    by_frequency: Floats | None = None

    @property
    def converged(self) -> bool:
        return self.status is Status.CONVERGED


@dataclass(frozen=True, eq=False)
class Arc:
    """The hyperplane a corrector stays on: moves from (x0, w0) that are normal to `tangent` (dx, dw) in `metric`."""

    x0: Floats
    w0: float
    tangent: Move
    metric: Metric

    def product(self, dx: Floats, dw: float) -> float:
        return self.metric.product(self.tangent, (dx, dw))


def solve(
    system: NonlinearSystem,
    excitation: Forcing,
    x: Floats,
    w: float,
    options: NewtonOptions | None = None,
    arc: Arc | None = None,
    near: DirectForces | None = None,
) -> Solution:
    """Newton with step halving from (x, w); at fixed w, or on the hyperplane `arc`.

    near: factors at a point nearby, by which the equations of the steps are preconditioned

    raises: nothing for want of convergence; the status tells
    """
    iterates = _iterates(system, excitation, (x, w), options or NewtonOptions(), arc, near)
    place = next(iterates)
    while True:
        try:
            place = iterates.send(evaluate(system, excitation, *place))
        except StopIteration as end:
            return cast(Solution, end.value)


def solve_together(
    system: NonlinearSystem, excitation: Forcing, arcs: Sequence[Arc], options: NewtonOptions | None = None
) -> list[Solution]:
    """As `solve`, from where each of the arcs begins: they advance in step, so that all are evaluated together."""
    each = [_iterates(system, excitation, (a.x0, a.w0), options or NewtonOptions(), a, None) for a in arcs]
    places, solved = {i: next(iterates) for i, iterates in enumerate(each)}, dict[int, Solution]()
    while places:
        equations = evaluate_together(system, excitation, tuple(places.values()))
        for i, equation in zip(tuple(places), equations, strict=True):
            try:
                places[i] = each[i].send(equation)
            except StopIteration as end:
                solved[i] = end.value
                del places[i]
    return [solved[i] for i in range(len(each))]


# Asks for the equation at one place (x, w) after the other.
_Iterates = Generator[tuple[Floats, float], Equation, Solution]


def _iterates(
    system: NonlinearSystem,
    excitation: Forcing,
    place: tuple[Floats, float],
    options: NewtonOptions,
    arc: Arc | None,
    near: DirectForces | None,
) -> _Iterates:
    equation = yield place
    errors, sizes = [equation.error], [float(np.linalg.norm(equation.residual))]
    step: _Step | None = None
    status = Status.TOO_MANY_ITERATIONS
    while len(errors) <= options.iterations and not (errors[-1] < options.tolerance and step is not None):
        bound = max(sizes[-options.memory :]) if options.damped else np.inf
        advanced = yield from _advance(system, excitation, equation, options, arc, step, near, bound)
        if isinstance(advanced, Status):
            status = advanced
            break
        equation, step = advanced
        near = step.jacobian.factors or near
        errors.append(equation.error)
        sizes.append(float(np.linalg.norm(equation.residual)))
        if options.out_of_patience(errors):
            status = Status.STALLED
            break
    if errors[-1] < options.tolerance and step is not None:
        status = Status.CONVERGED
    jacobian, slope = (None, None) if step is None else (step.jacobian, step.by_frequency)
    return Solution(equation.x, equation.w, status, len(errors) - 1, tuple(errors), equation, jacobian, slope)


def _advance(
    system: NonlinearSystem,
    excitation: Forcing,
    equation: Equation,
    options: NewtonOptions,
    arc: Arc | None,
    before: "_Step | None",
    near: DirectForces | None,
    bound: float,
) -> "Generator[tuple[Floats, float], Equation, tuple[Equation, _Step] | Status]":
    """The next iterate and the step that led to it, or why there is none."""
    if not np.isfinite(equation.error):
        return Status.DIVERGED
    try:
        step = _step(equation, equation.factorised(near), excitation, arc, before)
    except scipy.linalg.LinAlgError:
        return Status.DIVERGED
    found = yield from _damped(system, excitation, equation, (step.dx, step.dw), options, bound)
    return Status.STALLED if found is None else (found, step)


@dataclass(frozen=True, eq=False)
class _Step:
    """A Newton step; by_frequency: J^-1 dr/dw, None at fixed frequency; forces: what it came by"""

    dx: Floats
    dw: float
    jacobian: Jacobian
    by_frequency: Floats | None
    forces: Floats | None


def _step(equation: Equation, jacobian: Jacobian, excitation: Forcing, arc: Arc | None, before: _Step | None) -> _Step:
    """The Newton step, bordered by the arc's hyperplane where there is one (block elimination)."""
    by_residual = jacobian.solve(equation.residual)
    if arc is None:
        return _Step(-by_residual, 0.0, jacobian, None, None)
    start = before.forces if before is not None else None
    by_frequency, forces = jacobian.solve_from(equation.frequency_derivative(excitation), start)
    off_plane = arc.product(equation.x - arc.x0, equation.w - arc.w0)
    dw = (arc.product(by_residual, 0.0) - off_plane) / arc.product(-by_frequency, 1.0)
    return _Step(-by_residual - by_frequency * dw, dw, jacobian, by_frequency, forces)


def _damped(
    system: NonlinearSystem,
    excitation: Forcing,
    equation: Equation,
    step: tuple[Floats, float],
    options: NewtonOptions,
    bound: float,
) -> "Generator[tuple[Floats, float], Equation, Equation | None]":
    """The first of the full, half, ... step whose residual stays below the bound; None where none does.

    The bound is the largest of the last residuals, not the last one (Grippo, Lampariello and Lucidi 1986): where a
    contact changes its state the residual has a kink, and a step across it may have to go up first.
    """
    damping = 1.0
    floor = options.tolerance * equation.size

    def falls(residual: Floats) -> bool:
        return bool(np.linalg.norm(residual) < bound or np.abs(residual).max() < floor)

    while damping >= options.smallest_damping:
        x, w = equation.x + damping * step[0], equation.w + damping * step[1]
        # The full step is mostly taken, and then its tangents are needed; of the others only the last one's are.
        if damping == 1.0 or falls(residual_alone(system, excitation, x, w)):
            candidate = yield x, w
            if falls(candidate.residual):
                return candidate
        damping /= 2
    return None
