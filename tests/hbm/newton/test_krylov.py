"""GMRES against direct solution, warm starts, and honesty about failure."""

import numpy as np
import pytest

from updamp.hbm.newton.krylov import gmres


@pytest.fixture
def system():
    rng = np.random.default_rng(3)
    A = np.eye(80) + 0.3 * rng.normal(size=(80, 80)) / np.sqrt(80)
    return A, rng.normal(size=80)


def test_solves_to_the_tolerance(system):
    A, b = system
    for tolerance in (1e-3, 1e-8, 1e-12):
        found = gmres(lambda v: A @ v, b, None, tolerance, 80)
        assert found.converged
        assert np.linalg.norm(A @ found.value - b) <= 1.01 * tolerance * np.linalg.norm(b)
    np.testing.assert_allclose(found.value, np.linalg.solve(A, b), rtol=1e-9)


def test_a_good_start_saves_iterations(system):
    A, b = system
    cold = gmres(lambda v: A @ v, b, None, 1e-10, 80)
    near = np.linalg.solve(A, b) * (1 + 1e-6)
    warm = gmres(lambda v: A @ v, b, near, 1e-10, 80)
    assert warm.converged
    assert warm.iterations < cold.iterations
    assert gmres(lambda v: A @ v, b, np.linalg.solve(A, b), 1e-10, 80).iterations == 0


def test_says_when_it_did_not_converge(system):
    A, b = system
    found = gmres(lambda v: A @ v, b, None, 1e-12, 3)
    assert not found.converged
    assert found.iterations == 3


def test_never_more_iterations_than_distinct_eigenvalues():
    values = np.repeat([1.0, 2.0, 5.0], 20)
    found = gmres(lambda v: values * v, np.arange(1.0, 61.0), None, 1e-12, 60)
    assert found.converged
    assert found.iterations <= 3
