"""The response at one frequency with its amplitude held, as the controller of a response-controlled test holds it.

The force is unknown in place of the amplitude: Newton's equations of the harmonic balance are bordered by the condition
that the first harmonic at one row has the amplitude wanted. Where the force sets the response, a softening or hardening
resonance folds over; with the response held it does not (S. Karaagacli and H. N. Ozguven, MSSP 156 (2021) 107651), as
long as what is nonlinear moves with what is held: an absorber on a held mass folds over still.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton.equation import Equation, evaluate, linear_solution
from updamp.hbm.newton.newton import NewtonOptions, Solution, Status
from updamp.hbm.newton.structure_response import Loads, respond
from updamp.hbm.newton.tangent import apply_tangent
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
# Largest change of the logarithm of the force in one step.
_LARGEST = 1.0
_ALL = slice(None)


@dataclass(frozen=True, eq=False)
class HeldAmplitude:
    """excited, row: rows of the linear model where the force acts and whose response is held; amplitude: of its first
    harmonic [m]"""

    excited: int
    row: int
    amplitude: float


@dataclass(frozen=True, eq=False)
class HeldSolution:
    """solution: of the harmonic balance with `force` [N]"""

    solution: Solution
    force: float

    @property
    def converged(self) -> bool:
        return self.solution.converged


def linear_start(system: NonlinearSystem, held: HeldAmplitude, w: float) -> tuple[Floats, float]:
    """Relative displacements and force with all elements stuck: the natural first guess."""
    unit = Excitation(held.excited, 1.0)
    motion = Receptance(system, w).excitation(unit, np.array([held.row]))
    force = held.amplitude / float(np.abs(system.harmonics.amplitude(motion[0], 1)))
    return force * linear_solution(system, w, unit), force


def solve_held(
    system: NonlinearSystem,
    held: HeldAmplitude,
    start: tuple[Floats, float],
    w: float,
    options: NewtonOptions | None = None,
) -> HeldSolution:
    """Newton from the start (x, force) at the angular frequency w [rad/s].

    raises: nothing for want of convergence; the status tells
    """
    options = options or NewtonOptions()
    x, log_force = start[0], float(np.log(start[1]))
    unit = Receptance(system, w).excitation(Excitation(held.excited, 1.0), _ALL)
    errors: list[float] = []
    status, jacobian = Status.TOO_MANY_ITERATIONS, None
    for _ in range(options.iterations + 1):
        excitation = Excitation(held.excited, float(np.exp(log_force)))
        equation = evaluate(system, excitation, x, w)
        lift = excitation.force * unit
        off, by_log_force, by_x = _condition(equation, lift[held.row], held)
        errors.append(max(equation.error, abs(off)))
        if not np.isfinite(errors[-1]):
            status = Status.DIVERGED
            break
        if errors[-1] < options.tolerance and jacobian is not None:
            status = Status.CONVERGED
            break
        try:
            jacobian = equation.factorised()
        except scipy.linalg.LinAlgError:
            status = Status.DIVERGED
            break
        dx, with_force = -jacobian.solve(equation.residual), jacobian.solve(lift[: len(x)])
        by_dx, by_force = by_x(np.stack([dx, with_force], axis=2))
        step = -(off + by_dx) / (by_log_force + by_force)
        step = float(np.clip(step, -_LARGEST, _LARGEST))
        x, log_force = x + dx + with_force * step, log_force + step
    solution = Solution(x, w, status, len(errors) - 1, tuple(errors), equation, jacobian)
    return HeldSolution(solution, excitation.force)


def _condition(
    equation: Equation, direct: Floats, held: HeldAmplitude
) -> tuple[float, float, Callable[[Floats], Floats]]:
    """By how much the logarithm of the amplitude is off, its derivative by the logarithm of the force with x held, and
    those along changes of x (n_relative, n_coefficients, n) as a function of them.

    direct: (n_coefficients,) motion of the row held under the excitation alone
    """
    receptance, departure = equation.receptance, equation.departure
    rows, harmonics = np.array([held.row]), receptance.system.harmonics
    amplitude = complex(harmonics.amplitude(direct - receptance.apply(departure.value, rows)[0], 1))

    def relative(change: Floats) -> Floats:
        return np.asarray((harmonics.amplitude(change, 1) / amplitude).real)

    def by_x(dx: Floats) -> Floats:
        loads = Loads.none(receptance, dx.shape[2])
        loads.forces[: len(dx)] = -apply_tangent(receptance.system, departure, dx)
        return relative(respond(receptance, loads).at(rows)[0].T)

    return float(np.log(abs(amplitude) / held.amplitude)), float(relative(direct)), by_x
