"""Inverses of the modal dynamic stiffness: against the matrix itself, and their rates against differences."""

import numpy as np
import pytest

from updamp.hbm.modal_inverse import Decomposed, Direct, modal_inverse


def matrices(viscous: float):
    """Modes over four decades, damping that couples them."""
    rng = np.random.default_rng(2)
    omega = np.geomspace(2e3, 2e7, 40)
    X = np.linalg.qr(np.eye(40) + 0.1 * rng.normal(size=(40, 40)))[0]
    hysteretic = omega[:, None] * (X @ np.diag(np.linspace(1e-3, 1e-2, 40)) @ X.T) * omega
    C = rng.normal(size=(40, 40))
    return omega**2, hysteretic, viscous * C @ C.T


@pytest.mark.parametrize(("viscous", "kind"), [(0.0, Decomposed), (0.3, Direct)])
def test_it_is_the_inverse_near_a_resonance_and_off_it(viscous, kind):
    omega_squared, hysteretic, C = matrices(viscous)
    inverse = modal_inverse(omega_squared, hysteretic, C)
    assert isinstance(inverse, kind)
    scale = 1 / np.sqrt(omega_squared)
    for w in (1.99e3, 2e3, 2.5e3, 7e3):
        D = np.diag(omega_squared - w**2) + 1j * (hysteretic + w * C)
        product = (scale[:, None] * D) @ (inverse.at(w) / scale)
        np.testing.assert_allclose(product, np.eye(40), atol=1e-9)


@pytest.mark.parametrize("viscous", [0.0, 0.3])
def test_its_rate_is_its_derivative(viscous):
    inverse, w, h = modal_inverse(*matrices(viscous)), 2.1e3, 0.1
    difference = (inverse.at(w + h) - inverse.at(w - h)) / (2 * h)
    rate = inverse.rate(w, inverse.at(w))
    assert np.abs(difference - rate).max() < 1e-5 * np.abs(rate).max()


def test_a_mode_that_is_free_to_move_is_inverted_anew():
    omega_squared, hysteretic, C = matrices(0.0)
    omega_squared[0] = 0.0
    assert isinstance(modal_inverse(omega_squared, hysteretic, C), Direct)


def test_modes_that_coincide_are_inverted_all_the_same():
    omega_squared, hysteretic, C = matrices(0.0)
    omega_squared[10:14] = omega_squared[10]
    w, scale = 2.2e3, 1 / np.sqrt(omega_squared)
    D = np.diag(omega_squared - w**2) + 1j * hysteretic
    product = (scale[:, None] * D) @ (modal_inverse(omega_squared, hysteretic, C).at(w) / scale)
    np.testing.assert_allclose(product, np.eye(40), atol=1e-9)
