import numpy as np
import pytest

from updamp.hbm.harmonics import Harmonics


@pytest.mark.parametrize("orders", [(0, 1, 2, 3), (1, 3), (1, 2, 3), (0, 1)])
def test_analysis_inverts_synthesis(orders):
    h = Harmonics(orders)
    np.testing.assert_allclose(h.analysis(16) @ h.synthesis(16), np.eye(h.n_coefficients), atol=1e-15)


def test_sign_of_the_complex_amplitude():
    """cos(w t - phi) = Re(X e^{iwt}) with X = e^{-i phi}: a lag is a negative phase."""
    h = Harmonics((0, 1))
    phase = h.phase(64)
    coefficients = h.analysis(64) @ np.cos(phase - 0.3)
    assert np.angle(h.amplitude(coefficients, 1)) == pytest.approx(-0.3)
    written = np.zeros(3)
    h.set_amplitude(written, 1, np.exp(-0.3j))
    np.testing.assert_allclose(written, coefficients, atol=1e-15)


def test_rate_is_the_derivative():
    h = Harmonics((0, 1, 2, 5))
    c = np.random.default_rng(0).normal(size=h.n_coefficients)
    phase = h.phase(400)
    samples, rate = h.synthesis(400) @ c, h.synthesis_rate(400) @ c
    np.testing.assert_allclose(rate[1:-1], ((samples[2:] - samples[:-2]) / (phase[2:] - phase[:-2])), atol=0.02)


def test_change_of_harmonics_keeps_the_motion():
    few, many = Harmonics((1, 3)), Harmonics((0, 1, 2, 3, 4))
    c = np.random.default_rng(1).normal(size=(2, 4))
    more = few.change_to(many, c)
    np.testing.assert_allclose(many.synthesis(32) @ more.T, few.synthesis(32) @ c.T, atol=1e-14)
    np.testing.assert_array_equal(many.change_to(few, more), c)


@pytest.mark.parametrize("orders", [(), (0, 2), (1, 1), (3, 1), (-1, 1), (1, 2.5), (1, "3"), 3])
def test_bad_orders_are_named(orders):
    with pytest.raises(ValueError, match="ascending"):
        Harmonics(orders)


def test_a_list_or_whole_numbers_written_as_floats_will_do():
    assert hash(Harmonics([1, 3])) == hash(Harmonics((1.0, 3.0))) == hash(Harmonics((1, 3)))
    assert Harmonics(np.arange(3.0)).slices == Harmonics((0, 1, 2)).slices


def test_too_few_samples():
    with pytest.raises(ValueError, match="time_samples = 6"):
        Harmonics((1, 3)).analysis(6)
