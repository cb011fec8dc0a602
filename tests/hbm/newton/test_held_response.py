"""Response held, force unknown: against the closed form of one mode with a cubic spring."""

import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.held_response import HeldAmplitude, linear_start, solve_held
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import Excitation, NonlinearSystem

MASS, OMEGA, ETA, CUBIC = 2.0, 500.0, 0.004, 4e11
AMPLITUDE = 2e-4


@pytest.fixture(scope="module")
def system() -> NonlinearSystem:
    phi = np.full((2, 1), MASS**-0.5)
    linear = LinearModel(
        np.array([OMEGA**2]), phi, np.zeros((2, 2)), np.array([[ETA * OMEGA**2]]), np.zeros((1, 1)), 1, ("drive",)
    )
    spring = ElementGroup(CubicSpring(), CubicParameters(jnp.full(1, CUBIC)), np.array([[0]]))
    return NonlinearSystem(linear, (spring,), Harmonics((1,)), 64)


def test_force_that_holds_the_response_is_the_dynamic_stiffness_times_it(system: NonlinearSystem) -> None:
    """Each from the one before. With this force there are three responses near 505 rad/s: the one of the amplitude
    wanted is found."""
    held, start = HeldAmplitude(1, 1, AMPLITUDE), None
    for w in np.arange(480.0, 526.0, 0.25):
        found = solve_held(system, held, start or linear_start(system, held, w), w)
        assert found.converged
        hardened = MASS * OMEGA**2 + 0.75 * CUBIC * AMPLITUDE**2
        expected = abs(hardened + 1j * ETA * MASS * OMEGA**2 - MASS * w**2) * AMPLITUDE
        assert found.force == pytest.approx(expected, rel=1e-8)
        x = found.solution.x
        assert np.linalg.norm(x[0]) == pytest.approx(AMPLITUDE, rel=1e-8)
        assert evaluate(system, Excitation(1, found.force), x, w).error < 1e-8
        start = x, found.force


def test_want_of_convergence_is_told(system: NonlinearSystem) -> None:
    held = HeldAmplitude(1, 1, AMPLITUDE)
    found = solve_held(system, held, linear_start(system, held, 505.0), 505.0, NewtonOptions(iterations=1))
    assert not found.converged
    assert found.solution.status is Status.TOO_MANY_ITERATIONS
