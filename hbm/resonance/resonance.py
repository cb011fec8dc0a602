"""Harmonic balance with frequency and force as unknowns too, and the phase of one displacement as a condition.

Unknowns are z = x / F (the response to a unit force, constant while the system is linear), w and ln F; the equations
are the harmonic balance, the phase of the observed displacement (Peeters, Kerschen and Golinval 2011 call -90 degrees
phase quadrature), and a hyperplane on which the solution is looked for: constant force, or a step of continuation.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton import observe
from updamp.hbm.newton.active_forces import DirectForces
from updamp.hbm.newton.equation import Equation, evaluate
from updamp.hbm.newton.jacobian import Jacobian
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.newton.tangent import apply_tangent
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]

_MOST_LOG_FORCE = 100.0  # Newton's method may ask for more than a number holds
PHASE_TOLERANCE = 1e-7  # [rad]; an error e of the phase is one of e^2 / 2 of the peak


@dataclass(frozen=True, eq=False)
class ResonanceProblem:
    """excited, observed: rows of the linear model that the force acts on and whose first harmonic is followed
    near: factors at a similar point, to iterate with; whole: the structure where `system` is the half that is driven"""

    system: NonlinearSystem
    excited: int
    observed: int
    near: DirectForces | None = None
    whole: NonlinearSystem | None = None

    def excitation(self, log_force: float) -> Excitation:
        """log_force: ln of the force in N"""
        return Excitation(self.excited, float(np.exp(log_force)))


@dataclass(frozen=True, eq=False)
class ResonanceState:
    """The unknowns, of a solution or of a guess: z (n_relative, n_coefficients) [m/N], w [rad/s], ln F; phase [rad]"""

    z: Floats
    w: float
    log_force: float
    phase: float


@dataclass(frozen=True, eq=False)
class Hyperplane:
    """<normal, state - origin> = 0, as on a response curve with ln F besides; phase takes no part."""

    origin: ResonanceState
    normal: ResonanceState
    metric: Metric

    def product(self, dz: Floats, dw: float, dlog_force: float) -> float:
        n = self.normal
        return self.metric.product((n.z, n.w), (dz, dw)) + n.log_force * dlog_force

    def offset(self, state: ResonanceState) -> float:
        o = self.origin
        return self.product(state.z - o.z, state.w - o.w, state.log_force - o.log_force)


def constant_force_plane(state: ResonanceState) -> Hyperplane:
    normal = ResonanceState(np.zeros_like(state.z), 0.0, 1.0, 0.0)
    return Hyperplane(state, normal, Metric(np.ones(state.z.shape[1]), 1.0))


@dataclass(frozen=True, eq=False)
class Linearised:
    """The equations about one point; d ln y = d ln |y| + i d(phase) of the observed first harmonic y.

    by_residual, by_frequency, by_log_force: J^-1 r, J^-1 dr/dw, J^-1 dr/dlnF [m, m s, m]
    y_by_residual: d ln y for dx = by_residual
    y_by_frequency, y_by_log_force: d ln y / dw along the response at constant force [s], d ln y / d ln F at constant w
    """

    jacobian: Jacobian
    by_residual: Floats
    by_frequency: Floats
    by_log_force: Floats
    y_by_residual: complex
    y_by_frequency: complex
    y_by_log_force: complex

    @property
    def lag_to_maximum(self) -> float:
        """How far the phase has still to fall to the maximum [rad], in (-pi/2, pi/2); 0 at it.

        The angle between the response's direction and the normal to its Nyquist curve: exact on a circle.
        """
        along = self.y_by_frequency
        return float(np.arctan(along.real / -along.imag)) if along.imag else np.pi / 2


def linearise(problem: ResonanceProblem, equation: Equation, log_force: float) -> Linearised:
    """raises: scipy.linalg.LinAlgError where a tangent is not finite"""
    excitation, receptance = problem.excitation(log_force), equation.receptance
    stuck, harmonics = problem.system.stuck, problem.system.harmonics
    jacobian = equation.factorised(near=problem.near)
    residual = jacobian.solve(equation.residual)
    frequency = jacobian.solve(equation.frequency_derivative(excitation))
    by_log_force = jacobian.solve(-receptance.excitation(excitation))

    phi, observed_shape = stuck.phi[: stuck.n_relative], stuck.phi[problem.observed]
    modal = stuck.modal_inverse.at(receptance.w, (1,))
    observed_modes = modal.times(observed_shape.astype(np.complex128)[:, None])[:, 0]
    row = phi @ observed_modes + stuck.residual[problem.observed, : stuck.n_relative]
    direct = observed_modes @ stuck.phi[problem.excited] + stuck.residual[problem.observed, problem.excited]
    load = excitation.force * stuck.phi[problem.excited] - phi.T @ harmonics.amplitude(equation.departure.value, 1)
    y = excitation.force * direct - row @ harmonics.amplitude(equation.departure.value, 1)
    rate = observed_shape @ modal.rate_times(load[:, None])[:, 0]
    rate -= row @ harmonics.amplitude(equation.departure.frequency_derivative, 1)

    def by_displacement(dx: Floats) -> complex:
        tangent_force = apply_tangent(problem.system, equation.departure, dx)
        return complex(-(row @ harmonics.amplitude(tangent_force, 1)) / y)

    return Linearised(
        jacobian,
        residual,
        frequency,
        by_log_force,
        by_displacement(residual),
        complex(rate / y) - by_displacement(frequency),
        complex(excitation.force * direct / y) - by_displacement(by_log_force),
    )


def linearised_at(problem: ResonanceProblem, state: ResonanceState) -> Linearised:
    """raises: scipy.linalg.LinAlgError where a tangent is not finite"""
    excitation = problem.excitation(state.log_force)
    return linearise(
        problem, evaluate(problem.system, excitation, excitation.force * state.z, state.w), state.log_force
    )


@dataclass(frozen=True, eq=False)
class ResonanceSolution:
    """One solution of the extended equations.

    response: (n_coefficients,) of the observed displacement [m]
    iterations: the most that Newton's method needed; error: residual over displacement
    """

    problem: ResonanceProblem
    state: ResonanceState
    equation: Equation
    response: Floats
    status: Status
    iterations: int
    error: float

    @property
    def converged(self) -> bool:
        return self.status is Status.CONVERGED

    @property
    def x(self) -> Floats:
        """(n_relative, n_coefficients) [m]"""
        return self.equation.x

    @property
    def w(self) -> float:
        return self.state.w

    @property
    def frequency(self) -> float:
        """[Hz]"""
        return self.state.w / (2 * np.pi)

    @property
    def force(self) -> float:
        """[N]"""
        return float(np.exp(self.state.log_force))

    @property
    def excitation(self) -> Excitation:
        return self.problem.excitation(self.state.log_force)

    @property
    def amplitude(self) -> complex:
        """First harmonic of the observed displacement [m]."""
        return complex(self.problem.system.harmonics.amplitude(self.response, 1))

    @cached_property
    def linearised(self) -> Linearised:
        """With factors of its own: the sign of the determinant comes with them."""
        return linearise(replace(self.problem, near=None), self.equation, self.state.log_force)


def at_phase(
    problem: ResonanceProblem, guess: ResonanceState, plane: Hyperplane, options: NewtonOptions | None = None
) -> ResonanceSolution:
    """Newton's method with step halving for the response on `plane` whose phase is `guess.phase`.

    raises: nothing for want of convergence; the status tells
    """
    options = options or NewtonOptions()
    trial = _Trial.at(problem, guess)
    iterations, errors = 0, [trial.error]
    while True:
        if trial.converged(options) and iterations:
            return trial.solution(Status.CONVERGED, iterations)
        if not np.isfinite(trial.error):
            return trial.solution(Status.DIVERGED, iterations)
        if iterations == options.iterations:
            return trial.solution(Status.TOO_MANY_ITERATIONS, iterations)
        try:
            step = _step(trial, plane)
        except (scipy.linalg.LinAlgError, np.linalg.LinAlgError):
            return trial.solution(Status.DIVERGED, iterations)
        better = _damped(trial, step, options)
        if better is None:
            return trial.solution(Status.STALLED, iterations)
        trial = better
        iterations += 1
        errors.append(trial.error)
        if options.out_of_patience(errors) and not trial.converged(options):
            return trial.solution(Status.STALLED, iterations)


@dataclass(frozen=True, eq=False)
class _Trial:
    """A state with its residuals; phase_error is the observed phase less the wanted [rad]."""

    problem: ResonanceProblem
    state: ResonanceState
    equation: Equation
    response: Floats
    phase_error: float

    @staticmethod
    def at(problem: ResonanceProblem, state: ResonanceState) -> "_Trial":
        excitation = problem.excitation(state.log_force)
        equation = evaluate(problem.system, excitation, excitation.force * state.z, state.w)
        response = observe.response(equation, excitation, np.array([problem.observed]))[0]
        amplitude = problem.system.harmonics.amplitude(response, 1)
        return _Trial(problem, state, equation, response, float(np.angle(amplitude * np.exp(-1j * state.phase))))

    @property
    def error(self) -> float:
        return max(self.equation.error, abs(self.phase_error))

    def converged(self, options: NewtonOptions) -> bool:
        return self.equation.error < options.tolerance and abs(self.phase_error) < PHASE_TOLERANCE

    def solution(self, status: Status, iterations: int) -> ResonanceSolution:
        return ResonanceSolution(
            self.problem, self.state, self.equation, self.response, status, iterations, self.equation.error
        )


def _step(trial: _Trial, plane: Hyperplane) -> tuple[Floats, float, float]:
    """Newton's step (dz, dw, dlnF) by block elimination: two bordering rows, phase and plane."""
    line = linearise(trial.problem, trial.equation, trial.state.log_force)
    force, state = np.exp(trial.state.log_force), trial.state
    columns: list[tuple[Floats, float, float]] = [
        (-line.by_residual / force, 0.0, 0.0),
        (-line.by_frequency / force, 1.0, 0.0),
        (-(line.by_log_force / force + state.z), 0.0, 1.0),
    ]
    on_plane = [plane.product(*column) for column in columns]
    border = np.array([[line.y_by_frequency.imag, line.y_by_log_force.imag], on_plane[1:]])
    wanted = np.array([line.y_by_residual.imag - trial.phase_error, -plane.offset(state) - on_plane[0]])
    dw, dlog_force = np.linalg.solve(border, wanted)
    return columns[0][0] + dw * columns[1][0] + dlog_force * columns[2][0], float(dw), float(dlog_force)


def _damped(trial: _Trial, step: tuple[Floats, float, float], options: NewtonOptions) -> _Trial | None:
    """The first of the full, half, ... step that lowers the larger of both errors; None where none does."""
    damping, state = 1.0, trial.state
    while damping >= options.smallest_damping:
        dz, dw, dlog_force = step
        next_state = replace(
            state, z=state.z + damping * dz, w=state.w + damping * dw, log_force=state.log_force + damping * dlog_force
        )
        if next_state.w > 0 and abs(next_state.log_force) < _MOST_LOG_FORCE:
            candidate = _Trial.at(trial.problem, next_state)
            if not options.damped or candidate.error < trial.error or candidate.converged(options):
                return candidate
        damping /= 2
    return None
