"""The Jacobian against differences, statuses, and options that refuse bad values by name."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from support.peers import blades_and_damper_system, one_degree_of_freedom

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.continuation.continuation import ContinuationOptions, first_point
from updamp.hbm.newton.active_forces import DirectForces, KrylovForces
from updamp.hbm.newton.equation import evaluate, linear_solution
from updamp.hbm.newton.jacobian import factorise
from updamp.hbm.newton.newton import NewtonOptions, Status, solve
from updamp.hbm.newton.tangent import active_rows, apply_tangent
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation


class YieldParameters(NamedTuple):
    """stiffness: (n_elements,) [N/m]"""

    stiffness: jax.Array


@dataclass(frozen=True)
class YieldingSpring:
    """f = k u, at most 1 N either way, without memory."""

    parameters: ClassVar[type] = YieldParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: YieldParameters) -> jax.Array:  # noqa: ARG002
        return jnp.clip(parameters.stiffness * displacement, -1.0, 1.0)

    def reference_stiffness(self, parameters: YieldParameters) -> jax.Array:
        return parameters.stiffness[None]


@pytest.fixture(params=[JenkinsBox(2), CoulombCircle(3)], ids=["box", "circle"])
def slipping(request):
    """A solved point with slip and separation."""
    system = blades_and_damper_system(request.param)
    excitation = Excitation(system.free.row("excitation"), 40.0)
    solution = first_point(system, excitation, 2 * np.pi * 232.0)
    assert solution.converged
    return system, excitation, solution


def test_jacobian_against_differences(slipping):
    """J (J^-1 d) = d, with J applied by central differences of the residual, in random directions."""
    system, excitation, solution = slipping
    jacobian = factorise(solution.equation.receptance, solution.equation.departure)
    assert jacobian.n_active > 0
    rng = np.random.default_rng(0)
    for _ in range(4):
        d = rng.normal(size=solution.x.shape) * np.abs(solution.x).max()
        v = jacobian.solve(d)
        step = 1e-7 * np.abs(solution.x).max() / np.abs(v).max()
        ahead, behind = (evaluate(system, excitation, solution.x + s * step * v, solution.w).residual for s in (1, -1))
        np.testing.assert_allclose((ahead - behind) / (2 * step), d, atol=2e-6 * np.abs(d).max())


def test_factors_of_a_point_nearby_leave_little_to_iterate_on(slipping):
    """Of another frequency, with rows that were not active there: y + T G y = b is solved as by factors of this one."""
    system, excitation, solution = slipping
    there, here = (evaluate(system, excitation, (1 + e) * solution.x, (1 + e) * solution.w) for e in (0.0, 0.002))
    rows = active_rows(system, here.departure)
    near = DirectForces(there.receptance, there.departure, rows[2:])
    exact = DirectForces(here.receptance, here.departure, rows)
    found = KrylovForces(here.receptance, here.departure, rows, near, tolerance=1e-6)
    b = apply_tangent(system, here.departure, np.random.default_rng(0).normal(size=solution.x.shape))
    y = found(b)
    np.testing.assert_allclose(
        y + apply_tangent(system, here.departure, here.receptance.apply(y)), b, atol=1e-5 * np.abs(b).max()
    )
    np.testing.assert_allclose(exact(b), y, atol=1e-5 * np.abs(y).max())
    assert found.factors is near, "it was found by iteration"
    assert 0 < found.iterations < 25  # 2 rows of 7 coefficients have changed much, the others little


@pytest.mark.parametrize("worth", [10_000, 1])
def test_many_right_sides_by_iteration_are_those_of_a_factorisation(slipping, monkeypatch, worth):
    """However large each is: what contacts hardly depart by has squares that are none, and was taken to be solved by
    nothing. Where all of them would take longer than a factorisation, by that."""
    system, _, solution = slipping
    equation = solution.equation
    rows = active_rows(system, equation.departure)
    monkeypatch.setattr(KrylovForces, "_iterations_for_many", worth)
    iterated = KrylovForces(equation.receptance, equation.departure, rows)
    right = np.random.default_rng(0).normal(size=(len(rows), system.harmonics.n_coefficients, 4))
    right *= [1.0, 1e9, 0.0, 1e-170]
    found = iterated.solve(right)
    wanted = DirectForces(equation.receptance, equation.departure, rows).solve(right)
    for j in range(4):
        np.testing.assert_allclose(found[:, :, j], wanted[:, :, j], rtol=0, atol=1e-7 * np.abs(wanted[:, :, j]).max())
    assert (iterated.factors is None) == (worth > 1)


def test_frequency_derivative_against_differences(slipping):
    system, excitation, solution = slipping
    exact = solution.equation.frequency_derivative(excitation)
    step = 1e-5 * solution.w
    ahead, behind = (evaluate(system, excitation, solution.x, solution.w + s * step).residual for s in (1, -1))
    np.testing.assert_allclose((ahead - behind) / (2 * step), exact, atol=1e-5 * np.abs(exact).max())


def test_newton_converges_quadratically(slipping):
    system, excitation, solution = slipping
    disturbed = solution.x * (1 + 1e-3 * np.random.default_rng(1).normal(size=solution.x.shape))
    again = solve(system, excitation, disturbed, solution.w, NewtonOptions(tolerance=1e-13))
    assert again.converged
    np.testing.assert_allclose(again.x, solution.x, atol=1e-8 * np.abs(solution.x).max())
    assert again.iterations <= 5


def test_stuck_contacts_cost_no_unknowns():
    system = blades_and_damper_system(JenkinsBox(2))
    excitation = Excitation(system.free.row("excitation"), 1e-3)
    w = 2 * np.pi * 232.0
    solution = solve(system, excitation, linear_solution(system, w, excitation), w)
    assert solution.converged
    assert solution.jacobian is not None
    assert solution.jacobian.n_active == 0


def test_status_says_what_to_try(slipping):
    system, excitation, solution = slipping
    short = solve(system, excitation, 0.5 * solution.x, solution.w, NewtonOptions(tolerance=1e-13, iterations=1))
    assert short.status is Status.TOO_MANY_ITERATIONS
    assert "step" in short.status.advice
    broken = solve(system, excitation, np.full_like(solution.x, np.nan), solution.w)
    assert broken.status is Status.DIVERGED
    assert "wire" in broken.status.advice


def test_without_progress_it_is_given_up_after_its_patience(slipping):
    """Undamped from the motion turned over, where the residual goes up and down: with each patience the same iterates,
    ended where the residual then is above 0.3 of the first.
    """
    system, excitation, solution = slipping
    start = -solution.x
    never = solve(system, excitation, start, solution.w, NewtonOptions(damped=False))
    ended = []
    for patience in range(1, never.iterations):
        given = solve(system, excitation, start, solution.w, NewtonOptions(damped=False, patience=patience))
        ended.append(never.errors[patience] > 0.3 * never.errors[0])
        assert given.errors == never.errors[: patience + 1 if ended[-1] else None]
        assert given.status is (Status.STALLED if ended[-1] else never.status)
    assert any(ended)
    assert not all(ended)


def test_where_full_steps_go_to_and_fro_steps_that_lower_the_residual_find_the_solution():
    """A spring of 1000 N/m that yields elastically at 1 N bears 0.5 N beside one of 1 N/m: it does not yield.
    From beyond either limit full steps lead beyond the other one."""
    group = ElementGroup(YieldingSpring(), YieldParameters(np.array([1000.0])), np.array([[0]]))
    system = one_degree_of_freedom(0.0, group, (1,), 128)
    excitation, start = Excitation(system.free.row("mass"), 0.5), np.array([[3.0, 0.0]])
    full = NewtonOptions(damped=False, patience=5)
    assert solve(system, excitation, start, 1e-3, full).status is Status.STALLED
    found = solve(system, excitation, start, 1e-3, full.lowering)
    assert found.converged
    assert found.x[0] == pytest.approx([0.5 / (1001 - 1e-6), 0.0], rel=1e-6)


@pytest.mark.parametrize(("stiffness", "most"), [(1e2, 1e-9), (1e5, 1e-4 * 1e-2 / 1e5), (1e13, 1e-12)])
def test_a_residual_is_measured_by_the_force_that_it_stands_for(stiffness, most):
    """A residual counts as solved up to 1e-9 of the displacement, and where its force in the contact is at most 1e-4 of
    the excitation; round-off, 1e-12 of the displacement, always."""
    group = ElementGroup(YieldingSpring(), YieldParameters(np.array([stiffness])), np.array([[0]]))
    system = one_degree_of_freedom(0.0, group, (1,), 128)
    equation = evaluate(system, Excitation(system.free.row("mass"), 1e-2), np.array([[1.0, 0.0]]), 1e-3)
    assert NewtonOptions().tolerance * equation.size == pytest.approx(most)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (lambda: NewtonOptions(tolerance=1.0), "tolerance"),
        (lambda: NewtonOptions(iterations=0), "iterations"),
        (lambda: NewtonOptions(patience=0), "patience"),
        (lambda: ContinuationOptions(smallest_step=1.0), "smallest_step"),
        (lambda: ContinuationOptions(max_points=1), "max_points"),
    ],
)
def test_options_refuse_bad_values_by_name(options, name):
    with pytest.raises(ValueError, match=name):
        options()
