"""Many points of a branch together: what each of them is alone."""

import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.power_law_damper import PowerLawDamper, PowerLawParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.equation import evaluate, evaluate_together
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import Arc, solve, solve_together
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.receptance_along import ReceptanceAlong
from updamp.hbm.problem.system import Excitation, NonlinearSystem

W = np.array([0.9, 1.0, 1.13, 1.4])


def a_system(law=None, viscous=0.0, copies=None):
    """Six masses; between five of them and the ground a contact, a spring and a damper that grows with the velocity.
    viscous: damping in proportion to the stiffness, over 0.03 s; copies: of the contact"""
    rng = np.random.default_rng(4)
    part = rng.normal(size=(6, 6))
    K = part @ part.T / 6 + 2 * np.eye(6)
    linear = from_matrices(np.eye(6), 0.03 * viscous * K, K, np.eye(6)[:5], {"drive": np.eye(6)[5]})
    residual = 0.01 * np.eye(6)
    linear = type(linear)(**{**vars(linear), "hysteretic": 0.02 * np.diag(linear.omega_squared), "residual": residual})
    one = np.ones(1)
    friction = FrictionParameters(0.4 * one, 2.0 * one, 3.0 * one, 0.3 * one, np.zeros((1, 2)), 0 * one)
    groups = (
        ElementGroup(law or JenkinsBox(2), friction, np.array([[0, 1, 2]]), copies),
        ElementGroup(CubicSpring(), CubicParameters(jnp.asarray(0.7 * one)), np.array([[3]])),
        ElementGroup(PowerLawDamper(1.0), PowerLawParameters(0.1 * one, 1.5 * one), np.array([[4]])),
    )
    return NonlinearSystem(linear, groups, Harmonics((0, 1, 2, 3)), 64)


SYSTEMS = {
    "compiled": a_system(),
    "copies": a_system(copies=np.array([2.0])),
    "viscous": a_system(viscous=1.0),
    "JAX": a_system(CoulombCircle(2)),
}


@pytest.fixture(params=SYSTEMS.values(), ids=SYSTEMS)
def system(request):
    return request.param


def motions(system):
    """(5, n_coefficients, n)"""
    return np.random.default_rng(1).normal(size=(5, system.harmonics.n_coefficients, len(W)))


def assert_alike(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * max(np.abs(expected).max(), 1e-300))


def test_equations(system):
    excitation, x = Excitation(system.free.row("drive"), 0.5), motions(system)
    places = [(x[..., i], float(w)) for i, w in enumerate(W)]
    for found, place in zip(evaluate_together(system, excitation, places), places, strict=True):
        alone = evaluate(system, excitation, *place)
        assert_alike(found.residual, alone.residual)
        assert_alike(found.departure.value, alone.departure.value)
        assert_alike(found.departure.frequency_derivative, alone.departure.frequency_derivative)
        assert alone.departure.frequency_derivative.any(), "the damper depends on the frequency"
        for tangent, expected in zip(found.departure.tangents, alone.departure.tangents, strict=True):
            assert_alike(tangent, expected)


def test_forces_alone_and_those_that_are_known(system):
    x = motions(system)
    g = system.departure_values(x, W)
    for i, w in enumerate(W):
        assert_alike(g[..., i], system.departure_value(x[..., i], float(w)))
    assert np.array_equal(system.departure_values(x, W, (system, 2 * g)), 2 * g)


def test_what_the_structure_does(system):
    row, all_rows, forces = system.free.row("drive"), slice(None), motions(system)
    along, amplitudes = ReceptanceAlong(system, W), np.array([0.5, 1.0, 2.0, 3.0])
    many = np.stack([forces, -2 * forces], axis=3)
    found = {
        "apply": along.apply(many, all_rows)[..., 1],
        "excitation": along.excitation(row, amplitudes, all_rows),
        "motion": along.motion(row, amplitudes, forces, all_rows),
        "motion_rate": along.motion_rate(row, amplitudes, forces, all_rows),
    }
    for i, w in enumerate(W):
        alone, applied, force = Receptance(system, float(w)), Excitation(row, float(amplitudes[i])), forces[..., i]
        assert_alike(found["apply"][..., i], -2 * alone.apply(force, all_rows))
        assert_alike(found["excitation"][..., i], alone.excitation(applied, all_rows))
        assert_alike(found["motion"][..., i], alone.motion(applied, force, all_rows))
        assert_alike(found["motion_rate"][..., i], alone.motion_rate(applied, force, all_rows))


def test_solutions_along_arcs_of_which_some_are_not_found(system):
    excitation = Excitation(system.free.row("drive"), 0.5)
    arcs = []
    for i, w in enumerate(W):
        start = solve(system, excitation, 0 * motions(system)[..., i], float(w))
        x = start.x * (1.02 if i else np.nan)
        metric = Metric.at(start.x, system.harmonics, 1.0)
        arcs.append(Arc(x, float(w), (0 * x, 1.0), metric))
    found = solve_together(system, excitation, arcs)
    for solution, arc in zip(found, arcs, strict=True):
        alone = solve(system, excitation, arc.x0, arc.w0, arc=arc)
        assert (solution.status, solution.iterations) == (alone.status, alone.iterations)
        if alone.converged:
            np.testing.assert_allclose(solution.x, alone.x, rtol=0, atol=1e-9 * np.abs(alone.x).max())
    assert [solution.converged for solution in found] == [False, True, True, True]


def test_no_arcs_are_no_work(system):
    assert solve_together(system, Excitation(system.free.row("drive"), 0.5), []) == []
