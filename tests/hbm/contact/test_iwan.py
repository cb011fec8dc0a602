"""Micro-slip by Iwan's sliders: Masing's rule, Segalman's power law of dissipation, gross slip."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.iwan import REFERENCE_DISPLACEMENT, IwanMicroslip, IwanParameters

N = 2048
LAW = IwanMicroslip()
LOST = 5e3  # N/m


def parameters(exponent: float, nearness: float = 0.0) -> IwanParameters:
    return IwanParameters(jnp.asarray(LOST), jnp.asarray(exponent), jnp.asarray(nearness))


def cycle(amplitude: float) -> np.ndarray:
    return amplitude * np.cos(2 * np.pi * np.arange(N) / N)[:, None]


def force(u: np.ndarray, p: IwanParameters) -> np.ndarray:
    return np.asarray(LAW.force(jnp.asarray(u), jnp.zeros_like(u), p))[:, 0]


def area(u: np.ndarray, f: np.ndarray) -> float:
    closed = np.append(u, u[:1]), np.append(f, f[:1])
    return float(np.trapezoid(closed[1], closed[0]))


@pytest.mark.parametrize("exponent", [-0.6, 0.0, 0.7])
def test_dissipation_is_segalmans_power_law(exponent: float) -> None:
    """D = 4 R A^(3+chi) / ((2+chi) (3+chi)), R from the stiffness lost at the reference displacement; exact in A."""
    R = LOST * (1 + exponent) * (2 + exponent) / REFERENCE_DISPLACEMENT ** (1 + exponent)
    areas = []
    for amplitude in (2e-5, 3e-4):
        u = cycle(amplitude)
        areas.append(area(u[:, 0], force(u, parameters(exponent))))
        expected = 4 * R * amplitude ** (3 + exponent) / ((2 + exponent) * (3 + exponent))
        assert areas[-1] == pytest.approx(expected, rel=0.01)
    assert np.log(areas[1] / areas[0]) / np.log(15) == pytest.approx(3 + exponent, abs=1e-9)


@pytest.mark.parametrize("exponent", [-0.6, 0.0, 0.7])
def test_loop_obeys_masings_rule(exponent: float) -> None:
    """The way back from a peak is the first loading, twice as large: F(A) - F(u) = 2 F0((A - u) / 2), with
    F0(u) = -lost (u / REFERENCE_DISPLACEMENT)^(1+chi) u what is lost on it."""
    amplitude = 2e-4
    u = cycle(amplitude)
    f = force(u, parameters(exponent))
    back = slice(0, N // 2)
    half = (amplitude - u[back, 0]) / 2
    first_loading = -LOST * (half / REFERENCE_DISPLACEMENT) ** (1 + exponent) * half
    expected = f[0] - 2 * first_loading
    np.testing.assert_allclose(f[back], expected, atol=0.004 * np.abs(f).max())


def test_gross_slip_bounds_the_joints_force() -> None:
    """What sticks and what is lost together: the joint's force stays at its slip force once all sliders slip."""
    exponent, nearness = -0.4, 0.5
    end = REFERENCE_DISPLACEMENT / nearness
    R = LOST * (1 + exponent) * (2 + exponent) / REFERENCE_DISPLACEMENT ** (1 + exponent)
    K, slip = R * end ** (1 + exponent) / (1 + exponent), R * end ** (2 + exponent) / (2 + exponent)
    u = cycle(1e-3)  # all slip at 0.2 mm
    joint = K * u[:, 0] + force(u, parameters(exponent, nearness))
    np.testing.assert_allclose([joint.max(), joint.min()], [slip, -slip], rtol=0.01)
    assert area(u[:, 0], joint) == pytest.approx(4 * slip * (1e-3 - slip / K * _loop_share(exponent)), rel=0.01)


def _loop_share(exponent: float) -> float:
    """Of a power law up to phi_max: each slider takes 4 k phi (A - phi); the mean of k phi^2 over that of k phi, times
    K / F_s."""
    mean_square, mean = 1 / (3 + exponent), 1 / (2 + exponent)
    return (mean_square / mean) * ((2 + exponent) / (1 + exponent))


def test_tangent_is_that_of_a_difference() -> None:
    coefficients = jnp.array([1.5e-4, 0.4e-4, 0.3e-4, -0.2e-4])
    t = 2 * jnp.pi * jnp.arange(N) / N
    basis = jnp.stack([jnp.cos(t), jnp.sin(t), jnp.cos(3 * t), jnp.sin(3 * t)], axis=1)

    def harmonics(c: jax.Array) -> jax.Array:
        u = (basis @ c)[:, None]
        return 2 / N * basis.T @ LAW.force(u, jnp.zeros_like(u), parameters(-0.4))[:, 0]

    tangent = np.asarray(jax.jacfwd(harmonics)(coefficients))
    h = 1e-8
    for j in range(4):
        step = h * jnp.eye(4)[j]
        difference = (harmonics(coefficients + step) - harmonics(coefficients - step)) / (2 * h)
        np.testing.assert_allclose(tangent[:, j], difference, atol=0.01 * np.abs(tangent).max())


def test_nothing_moves_in_a_motion_of_nothing() -> None:
    u = jnp.zeros((64, 1))
    slope = jax.jacfwd(lambda v: LAW.force(v, jnp.zeros_like(v), parameters(-0.4)))(u)
    assert not np.asarray(LAW.force(u, u, parameters(-0.4))).any()
    assert np.isfinite(np.asarray(slope)).all()
