"""Newton's method on the harmonic balance residual, at fixed frequency or along an arc."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.jacobian import Jacobian, factorise
from updamp.hbm.system import Departure, Excitation, NonlinearSystem, Receptance

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

    raises: ValueError naming the option that is out of range
    """

    tolerance: float = 1e-9
    iterations: int = 25
    smallest_damping: float = 1 / 64

    def __post_init__(self) -> None:
        if not 1e-14 < self.tolerance < 1e-2:
            raise ValueError(f"tolerance = {self.tolerance}: allowed between 1e-14 and 1e-2")
        if self.iterations < 1:
            raise ValueError(f"iterations = {self.iterations}: at least 1")


@dataclass(frozen=True, eq=False)
class Equation:
    """Residual r(x, w) = x - x_lin(w) + G(w) g(x) at one point, with all that Newton needs.

    residual: (n_relative, n_coefficients) [m]
    """

    x: Floats
    w: float
    receptance: Receptance
    departure: Departure
    residual: Floats

    @property
    def error(self) -> float:
        """Largest residual over largest displacement; infinite where not finite."""
        size = np.abs(self.residual).max() / max(np.abs(self.x).max(), np.finfo(float).tiny)
        return float(size) if np.isfinite(size) else np.inf

    def frequency_derivative(self, excitation: Excitation) -> Floats:
        """dr/dw"""
        receptance = self.receptance
        return (
            receptance.apply_rate(self.departure.value)
            + receptance.apply(self.departure.frequency_derivative)
            - receptance.excitation_rate(excitation)
        )


@dataclass(frozen=True, eq=False)
class Solution:
    """x: (n_relative, n_coefficients) [m]; w [rad/s]; error: as in Equation, one entry an iteration"""

    x: Floats
    w: float
    status: Status
    iterations: int
    errors: tuple[float, ...]
    equation: Equation
    jacobian: Jacobian | None

    @property
    def converged(self) -> bool:
        return self.status is Status.CONVERGED


@dataclass(frozen=True, eq=False)
class Arc:
    """The hyperplane a corrector stays on: <tangent_x, x - x0> / scale_x^2 + tangent_w (w - w0) / scale_w^2 = 0."""

    x0: Floats
    w0: float
    tangent_x: Floats
    tangent_w: float
    scale_x: float
    scale_w: float

    def product(self, dx: Floats, dw: float) -> float:
        return float(np.vdot(self.tangent_x, dx) / self.scale_x**2 + self.tangent_w * dw / self.scale_w**2)


def evaluate(system: NonlinearSystem, excitation: Excitation, x: Floats, w: float) -> Equation:
    receptance = Receptance(system, w)
    departure = system.departure(x, w)
    residual = x - receptance.excitation(excitation) + receptance.apply(departure.value)
    return Equation(x, w, receptance, departure, residual)


def linear_solution(system: NonlinearSystem, w: float, excitation: Excitation) -> Floats:
    """All elements stuck: the natural first guess."""
    return Receptance(system, w).excitation(excitation)


def solve(
    system: NonlinearSystem,
    excitation: Excitation,
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
    errors = [equation.error]
    jacobian: Jacobian | None = None
    for _iteration in range(options.iterations):
        if errors[-1] < options.tolerance and jacobian is not None:
            return _solution(equation, Status.CONVERGED, errors, jacobian)
        if not np.isfinite(errors[-1]):
            return _solution(equation, Status.DIVERGED, errors, jacobian)
        try:
            jacobian = factorise(equation.receptance, equation.departure)
        except scipy.linalg.LinAlgError:
            return _solution(equation, Status.DIVERGED, errors, jacobian)
        dx, dw = _step(equation, jacobian, excitation, arc)
        candidate = _damped(system, excitation, equation, (dx, dw), options)
        if candidate is None:
            return _solution(equation, Status.STALLED, errors, jacobian)
        equation = candidate
        errors.append(equation.error)
    status = Status.CONVERGED if errors[-1] < options.tolerance else Status.TOO_MANY_ITERATIONS
    return _solution(equation, status, errors, jacobian)


def _solution(equation: Equation, status: Status, errors: list[float], jacobian: Jacobian | None) -> Solution:
    return Solution(equation.x, equation.w, status, len(errors) - 1, tuple(errors), equation, jacobian)


def _step(equation: Equation, jacobian: Jacobian, excitation: Excitation, arc: Arc | None) -> tuple[Floats, float]:
    """The Newton step, bordered by the arc's hyperplane where there is one (block elimination)."""
    by_residual = jacobian.solve(equation.residual)
    if arc is None:
        return -by_residual, 0.0
    by_frequency = jacobian.solve(equation.frequency_derivative(excitation))
    off_plane = arc.product(equation.x - arc.x0, equation.w - arc.w0)
    dw = (arc.product(by_residual, 0.0) - off_plane) / arc.product(-by_frequency, 1.0)
    return -by_residual - by_frequency * dw, dw


def _damped(
    system: NonlinearSystem,
    excitation: Excitation,
    equation: Equation,
    step: tuple[Floats, float],
    options: NewtonOptions,
) -> Equation | None:
    """The first of the full, half, ... step that lowers the residual; None where none does."""
    damping = 1.0
    before = np.abs(equation.residual).max()
    floor = options.tolerance * max(np.abs(equation.x).max(), np.finfo(float).tiny)
    while damping >= options.smallest_damping:
        candidate = evaluate(system, excitation, equation.x + damping * step[0], equation.w + damping * step[1])
        after = np.abs(candidate.residual).max()
        if after < before or after < floor:
            return candidate
        damping /= 2
    return None
