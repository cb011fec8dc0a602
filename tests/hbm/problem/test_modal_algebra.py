"""Small eigenvalues beside large ones keep their digits."""

import numpy as np
import pytest
import scipy.linalg

from updamp.hbm.problem.modal_algebra import DecomposedInverse, DirectInverse, graded_eigh, modal_inverse


def graded(rng: np.random.Generator, m: int, decades: float) -> tuple[np.ndarray, np.ndarray]:
    """D A D with a well-conditioned A; and D"""
    G = np.eye(m) + 0.3 * rng.normal(size=(m, m)) / np.sqrt(m)
    scale = 10.0 ** rng.permutation(np.linspace(0, decades / 2, m))
    return scale[:, None] * (G @ G.T) * scale, scale


def test_eigenvalues_of_the_inverse_are_the_inverse_ones():
    """Large eigenvalues of the inverse, which any solver gets right, are the small ones here."""
    rng = np.random.default_rng(4)
    matrix, scale = graded(rng, 12, 24.0)
    inverse = np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)
    lowest = 1 / scipy.linalg.eigvalsh((inverse + inverse.T) / 2)[::-1][:2]
    values, vectors = graded_eigh(matrix)
    np.testing.assert_allclose(values[:2], lowest, rtol=1e-13)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(12), atol=1e-13)
    assert abs(scipy.linalg.eigvalsh(matrix)[0] / lowest[0] - 1) > 1e-6  # or this test would show nothing


def test_every_vector_belongs_to_its_value():
    matrix, scale = graded(np.random.default_rng(5), 9, 12.0)
    values, vectors = graded_eigh(matrix)
    assert (np.diff(values) > 0).all()
    of_size_one = matrix / np.outer(scale, scale)
    left = of_size_one @ (scale[:, None] * vectors)
    np.testing.assert_allclose(left, vectors * values / scale[:, None], atol=1e-12 * np.abs(left).max())


@pytest.mark.parametrize("values", [(0.0, 0.0, 1.0, 3.0), (-1.0, 2.0, 5.0, 9.0)])
def test_without_positive_definiteness_it_is_the_usual_solver(values):
    Q = np.linalg.qr(np.random.default_rng(6).normal(size=(4, 4)))[0]
    matrix = Q * np.array(values) @ Q.T
    np.testing.assert_allclose(graded_eigh((matrix + matrix.T) / 2)[0], values, atol=1e-14)


# Inverses of the modal dynamic stiffness: against the matrix itself, and their rates against differences.


def matrices(viscous: float):
    """Modes over four decades, damping that couples them."""
    rng = np.random.default_rng(2)
    omega = np.geomspace(2e3, 2e7, 40)
    X = np.linalg.qr(np.eye(40) + 0.1 * rng.normal(size=(40, 40)))[0]
    hysteretic = omega[:, None] * (X @ np.diag(np.linspace(1e-3, 1e-2, 40)) @ X.T) * omega
    C = rng.normal(size=(40, 40))
    return omega**2, hysteretic, viscous * C @ C.T


@pytest.mark.parametrize(("viscous", "kind"), [(0.0, DecomposedInverse), (0.3, DirectInverse)])
def test_it_is_the_inverse_near_a_resonance_and_off_it(viscous, kind):
    omega_squared, hysteretic, C = matrices(viscous)
    inverse = modal_inverse(omega_squared, hysteretic, C)
    assert isinstance(inverse, kind)
    scale = 1 / np.sqrt(omega_squared)
    for w in (1.99e3, 2e3, 2.5e3, 7e3):
        D = np.diag(omega_squared - w**2) + 1j * (hysteretic + w * C)
        product = (scale[:, None] * D) @ (inverse.at(w, (1,)).matrix(0) / scale)
        np.testing.assert_allclose(product, np.eye(40), atol=1e-9)


@pytest.mark.parametrize("viscous", [0.0, 0.3])
def test_its_rate_is_its_derivative_at_every_multiple(viscous):
    inverse, w, h, orders = modal_inverse(*matrices(viscous)), 2.1e3, 0.01, (1, 2, 5)
    loads = np.random.default_rng(4).normal(size=(40, 3, 2)) + 0j
    ahead, behind = (inverse.at(w + step, orders).times(loads) for step in (h, -h))
    rate = inverse.at(w, orders).rate_times(loads)
    for i in range(3):
        assert np.abs((ahead - behind) / (2 * h) - rate)[:, i].max() < 1e-5 * np.abs(rate[:, i]).max()


@pytest.mark.parametrize("viscous", [0.0, 0.3])
def test_loads_are_answered_as_by_the_matrix_of_each_multiple(viscous):
    response, rng = modal_inverse(*matrices(viscous)).at(2.1e3, (1, 3)), np.random.default_rng(5)
    loads = rng.normal(size=(40, 2, 3)) + 1j * rng.normal(size=(40, 2, 3))
    for i in range(2):
        expected = response.matrix(i) @ loads[:, i]
        np.testing.assert_allclose(response.times(loads)[:, i], expected, atol=1e-12 * np.abs(expected).max())


def test_a_mode_that_is_free_to_move_is_inverted_anew():
    omega_squared, hysteretic, C = matrices(0.0)
    omega_squared[0] = 0.0
    assert isinstance(modal_inverse(omega_squared, hysteretic, C), DirectInverse)


def test_modes_that_coincide_are_inverted_all_the_same():
    omega_squared, hysteretic, C = matrices(0.0)
    omega_squared[10:14] = omega_squared[10]
    w, scale = 2.2e3, 1 / np.sqrt(omega_squared)
    D = np.diag(omega_squared - w**2) + 1j * hysteretic
    product = (scale[:, None] * D) @ (modal_inverse(omega_squared, hysteretic, C).at(w, (1,)).matrix(0) / scale)
    np.testing.assert_allclose(product, np.eye(40), atol=1e-9)
