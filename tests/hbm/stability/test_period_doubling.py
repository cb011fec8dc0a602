"""Multipliers on the negative real axis: a bilinear oscillator against a time integration, and Mathieu's equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b
from support.peers import one_degree_of_freedom
from support.quadratic_spring import QuadraticSpring

from updamp.hbm.contact.springs import CubicParameters, UnilateralParameters
from updamp.hbm.contact.stops import Stop
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.stability.stability import stability

K, C, F = 5.0, 0.02, 0.1


def _marched_multipliers(start, w):
    """(2,) of x'' + C x' + x + K max(x, 0) = F cos w t, by integrating a period with its variations."""

    def rate(t, y):
        force = F * np.cos(w * t) - C * y[1] - y[0] - K * max(y[0], 0.0)
        stiffness = 1.0 + K * (y[0] > 0)
        return [y[1], force, y[3], -C * y[3] - stiffness * y[2], y[5], -C * y[5] - stiffness * y[4]]

    period = 2 * np.pi / w
    end = solve_ivp(rate, (0, period), [*start, 1, 0, 0, 1], rtol=1e-9, atol=1e-12, max_step=period / 400).y[:, -1]
    np.testing.assert_allclose(end[:2], start, atol=0.02 * np.abs(start).max())
    return np.linalg.eigvals(end[2:].reshape(2, 2).T)


@pytest.mark.parametrize(
    ("hertz", "doubles"), [(0.28, False), (0.40, True), (0.45, True), (0.52, True), (0.59, True), (0.70, False)]
)
def test_a_bilinear_oscillator_doubles_its_period_where_marched_multipliers_say_so(hertz, doubles):
    parameters = UnilateralParameters(np.array([K]), np.zeros(1))
    system = one_degree_of_freedom(C, ElementGroup(Stop(), parameters, np.array([[0]])), tuple(range(12)), 256)
    w, h = 2 * np.pi * hertz, system.harmonics
    solution = first_point(system, Excitation(system.free.row("mass"), F), w)
    assert solution.converged
    start = (h.synthesis(8)[0] @ solution.x[0], w * h.synthesis_rate(8)[0] @ solution.x[0])
    marched, found = _marched_multipliers(start, w), stability(system, solution.x, w)
    assert (marched.real.min() < -1) == doubles
    assert found.trusted, found.reason
    assert found.stable != doubles
    assert found.exponents.sum().real == pytest.approx(-C, rel=1e-2)
    growth = np.log(np.abs(marched).max()) * w / (2 * np.pi)
    assert found.decisive.real == pytest.approx(growth, rel=0.01, abs=1e-4)
    if doubles:
        assert found.decisive.imag == pytest.approx(w / 2, rel=1e-3)


def _mathieu(n, a, q):
    """Stability of n equal masses with y'' + (a - 2 q cos 2 t) y = 0 each, without damping."""
    one = np.eye(n)
    group = ElementGroup(QuadraticSpring(), CubicParameters(np.full(n, -2 * q)), np.arange(n)[:, None])
    linear = from_matrices(one, 0 * one, a * one, one, {"drive": one[0]})
    system = NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3, 4, 5, 6, 7)), 128, as_a_whole=True)
    x = np.zeros((n, 15))
    x[:, 1] = 1.0
    return stability(system, x, 2.0)


@pytest.mark.parametrize("q", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("n", [1, 2])
def test_the_first_tongue_of_mathieu_s_equation(n, q):
    """Between b_1(q) and a_1(q) periods double; of equal masses every exponent is there more than once."""
    low, high = sorted((mathieu_b(1, q), mathieu_a(1, q)))
    step = 0.02 * (high - low)
    for a, doubles in ((low - step, False), (low + step, True), (1.0, True), (high - step, True)):
        found = _mathieu(n, a, q)
        assert found.trusted, found.reason
        assert found.stable != doubles, f"a = {a}"
        assert found.exponents.sum().real == pytest.approx(0.0, abs=1e-6)
        assert len(found.exponents) == 2 * n
        if doubles:
            assert found.decisive.imag % 2.0 == pytest.approx(1.0, rel=1e-4)
    assert _mathieu(n, high + step, q).stable
