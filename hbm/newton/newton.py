"""Newton's method on the harmonic balance residual, at fixed frequency or along an arc."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton.jacobian import Jacobian, factorise
from updamp.hbm.newton.metric import Metric, Move
from updamp.hbm.newton.tangent import supported
from updamp.hbm.problem.system import Departure, Excitation, Forcing, NonlinearSystem, Receptance

Floats = NDArray[np.float64]


class Status(Enum):
    """What became of a solution; `advice` says what to try."""

    CONVERGED = "converged"
    TOO_MANY_ITERATIONS = "too many iterations"
    DIVERGED = "diverged"
    STALLED = "stalled"

    @property
    def advice(self) -> str:
        return _ADVICE[self]


_ADVICE = {
    Status.CONVERGED: "",
    Status.TOO_MANY_ITERATIONS: "start closer (smaller step, neighbouring force level) or allow more iterations",
    Status.DIVERGED: "the residual is not finite: check stiffness, preload and the zero harmonic's support by the wire",
    Status.STALLED: "no step lowers the residual: use more time samples, or start from fewer harmonics",
}


@dataclass(frozen=True)
class NewtonOptions:
    """tolerance: largest residual over largest displacement; iterations: at most this many.
    smallest_damping: shortest part of a step that is tried
    memory: a residual may exceed the last one, but not all of this many
    damped: whether steps are shortened at all. Across a kink the full step solves the far side's equations, however
        much the residual rises on the way; shortened, it stays at the kink. For starts close to a solution.
    patience: given up where after so many iterations the residual is not below `PROGRESS` of the first; None: never
    support: share of their stiffness in the mean position that slipping and open contacts keep in Newton's tangent.
        Where they all slip in a direction, little holds the mean position: from a residual of 1e-10 of the displacement
        the exact step may go thousands of displacements, far beyond where contacts stick again. Solutions are the same,
        as the residual has no such support.

    raises: ValueError naming the option that is out of range
    """

    tolerance: float = 1e-9
    iterations: int = 12
    smallest_damping: float = 1 / 64
    memory: int = 4
    damped: bool = True
    patience: int | None = None
    support: float = 0.0

    def __post_init__(self) -> None:
        if not 1e-14 < self.tolerance < 1e-2:
            raise ValueError(f"tolerance = {self.tolerance}: allowed between 1e-14 and 1e-2")
        if self.iterations < 1:
            raise ValueError(f"iterations = {self.iterations}: at least 1")
        if self.patience is not None and self.patience < 1:
            raise ValueError(f"patience = {self.patience}: at least 1, or None")
        if not 0 <= self.support < 1:
            raise ValueError(f"support = {self.support}: at least 0 and below 1")

    def hopeless(self, errors: Sequence[float]) -> bool:
        """errors: of all iterates so far"""
        return len(errors) - 1 == self.patience and errors[-1] > PROGRESS * errors[0]


# What a corrector that will converge leaves of the first residual after its patience. Of 2,228 that did converge on the
# stress grid 17 had not come so far after four iterations and 2 after five; of 872 that did not, all but 87 and 105.
PROGRESS = 0.3


@dataclass(frozen=True, eq=False)
class Equation:
    """Residual r(x, w) = x - x_lin(w) + G(w) g(x) at one point, with all that Newton needs.

    w: [rad/s], or what varies along the branch in its place; residual: (n_relative, n_coefficients) [m]
    """

    x: Floats
    w: float
    receptance: Receptance
    departure: Departure
    residual: Floats

    @property
    def error(self) -> float:
        """Largest residual over largest displacement (`_size`); infinite where not finite."""
        size = np.abs(self.residual).max() / _size(self.receptance.system, self.x)
        return float(size) if np.isfinite(size) else np.inf

    def factorised(self, support: float = 0.0) -> Jacobian:
        """raises: scipy.linalg.LinAlgError where a tangent is not finite"""
        return factorise(self.receptance, supported(self.receptance.system, self.departure, support))

    def frequency_derivative(self, excitation: Forcing) -> Floats:
        """dr/dw"""
        receptance, (w_rate, force_rate) = self.receptance, excitation.rates(self.w)
        applied = excitation.at(self.w)[1]
        rate = np.zeros_like(self.x)
        if w_rate:
            rate += w_rate * (
                receptance.apply_rate(self.departure.value)
                + receptance.apply(self.departure.frequency_derivative)
                - receptance.excitation_rate(applied)
            )
        if force_rate:
            rate -= receptance.excitation(Excitation(applied.row, force_rate))
        return rate


# A mean position so many times the vibration does not make a solution better.
_MEAN_COUNTS = 1000.0


def _size(system: NonlinearSystem, x: Floats) -> float:
    """Largest displacement [m], the mean position's limited to so many times the vibration's."""
    largest = np.abs(x).max()
    if 0 in system.harmonics.orders:
        vibration = np.abs(np.delete(x, system.harmonics.slices[0], axis=1)).max(initial=0.0)
        largest = min(largest, _MEAN_COUNTS * vibration) if vibration else largest
    return float(max(largest, np.finfo(float).tiny))


@dataclass(frozen=True, eq=False)
class Solution:
    """x: (n_relative, n_coefficients) [m]; w [rad/s]; errors: as in Equation, one entry an iteration

    support: what Newton's tangents had of it (`NewtonOptions`)
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
    support: float = 0.0

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


def evaluate(system: NonlinearSystem, excitation: Forcing, x: Floats, w: float) -> Equation:
    frequency, applied = excitation.at(w)
    receptance = Receptance(system, frequency)
    departure = system.departure(x, frequency)
    residual = x - receptance.excitation(applied) + receptance.apply(departure.value)
    return Equation(x, w, receptance, departure, residual)


def residual_alone(system: NonlinearSystem, excitation: Forcing, x: Floats, w: float) -> Floats:
    """(n_relative, n_coefficients) [m], without the tangents, which are most of the cost of `evaluate`."""
    frequency, applied = excitation.at(w)
    receptance = Receptance(system, frequency)
    return x - receptance.excitation(applied) + receptance.apply(system.departure_value(x, frequency))


def linear_solution(system: NonlinearSystem, w: float, excitation: Excitation) -> Floats:
    """All elements stuck: the natural first guess."""
    return Receptance(system, w).excitation(excitation)


def open_solution(system: NonlinearSystem, w: float, excitation: Excitation) -> Floats:
    """No contact at all, about the position at rest: a guess where the force is large."""
    n = system.free.n_relative
    amplitude = excitation.force * system.free.receptance(w, slice(n), np.array([excitation.row]))[:, 0]
    response = np.zeros((n, system.harmonics.n_coefficients))
    system.harmonics.set_amplitude(response, 1, amplitude)
    return response


def solve(
    system: NonlinearSystem,
    excitation: Forcing,
    x: Floats,
    w: float,
    options: NewtonOptions | None = None,
    arc: Arc | None = None,
) -> Solution:
    """Newton with step halving from (x, w); at fixed w, or on the hyperplane `arc`.

    raises: nothing for want of convergence; the status tells
    """
    options = options or NewtonOptions()
    equation = evaluate(system, excitation, x, w)
    errors, sizes = [equation.error], [float(np.linalg.norm(equation.residual))]
    step: _Step | None = None
    status = Status.TOO_MANY_ITERATIONS
    while len(errors) <= options.iterations:
        if errors[-1] < options.tolerance and step is not None:
            status = Status.CONVERGED
            break
        if not np.isfinite(errors[-1]):
            status = Status.DIVERGED
            break
        try:
            step = _step(equation, equation.factorised(options.support), excitation, arc, step)
        except scipy.linalg.LinAlgError:
            status = Status.DIVERGED
            break
        bound = max(sizes[-options.memory :]) if options.damped else np.inf
        candidate = _damped(system, excitation, equation, (step.dx, step.dw), options, bound)
        if candidate is None:
            status = Status.STALLED
            break
        equation = candidate
        errors.append(equation.error)
        sizes.append(float(np.linalg.norm(equation.residual)))
        if options.hopeless(errors):
            status = Status.STALLED
            break
    if errors[-1] < options.tolerance and step is not None:
        status = Status.CONVERGED
        if options.support:
            equation, step = _without_support(system, excitation, equation, arc)
            errors.append(equation.error)
    jacobian, slope = (None, None) if step is None else (step.jacobian, step.by_frequency)
    place = (equation.x, equation.w)
    return Solution(*place, status, len(errors) - 1, tuple(errors), equation, jacobian, slope, options.support)


def _without_support(
    system: NonlinearSystem, excitation: Forcing, equation: Equation, arc: Arc | None
) -> tuple[Equation, "_Step"]:
    """One exact step more, for the branch's tangent; taken where the residual does not rise."""
    step = _step(equation, equation.factorised(), excitation, arc, None)
    further = evaluate(system, excitation, equation.x + step.dx, equation.w + step.dw)
    return (further if further.error <= equation.error else equation), step


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
) -> Equation | None:
    """The first of the full, half, ... step whose residual stays below the bound; None where none does.

    The bound is the largest of the last residuals, not the last one (Grippo, Lampariello and Lucidi 1986): where a
    contact changes its state the residual has a kink, and a step across it may have to go up first.
    """
    damping = 1.0
    floor = options.tolerance * _size(system, equation.x)

    def falls(residual: Floats) -> bool:
        return bool(np.linalg.norm(residual) < bound or np.abs(residual).max() < floor)

    while damping >= options.smallest_damping:
        x, w = equation.x + damping * step[0], equation.w + damping * step[1]
        # The full step is mostly taken, and then its tangents are needed; of the others only the last one's are.
        if damping == 1.0 or falls(residual_alone(system, excitation, x, w)):
            candidate = evaluate(system, excitation, x, w)
            if falls(candidate.residual):
                return candidate
        damping /= 2
    return None
