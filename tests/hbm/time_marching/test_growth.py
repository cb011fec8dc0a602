"""Rates of made-up sequences of states."""

import numpy as np
import pytest

from updamp.hbm.time_marching.growth import growth

T = 0.01
RNG = np.random.default_rng(7)


def _changes(exponents, n, noise=0.0):
    """(n, 30) from sum_k c_k e^(s_k i T) + a fixed point, all real."""
    i = np.arange(n + 1)[:, None]
    z = RNG.normal(size=30) + np.zeros((n + 1, 1))
    for s in exponents:
        z = z + np.real(np.exp(s * i * T) * (RNG.normal(size=30) + 1j * RNG.normal(size=30)))
    return np.diff(z + noise * RNG.normal(size=z.shape), axis=0)


@pytest.mark.parametrize("rate", [30.0, 3.0, -3.0])
def test_the_slowest_is_found_among_beating_ones(rate):
    told = growth(_changes([rate, -25 + 150j, -40 + 90j], 20), T)
    assert told.rate == pytest.approx(rate, abs=1e-3)
    assert told.error < 1e-6


def test_a_drift_does_not_grow_where_its_changes_beat():
    """Beats that swell throughout the time marched: no growth, though the changes' size rises."""
    slow = 2 * np.pi / (4 * 20 * T)
    told = growth(_changes([-1 + 1j * (100 + slow), -1 + 1j * (100 - slow), -60], 24, 1e-6), T)
    assert told.rate < 1 / (24 * T) / 4


def test_noise_tells_nothing_of_growth():
    told = growth(RNG.normal(size=(20, 30)), T)
    assert np.isnan(told.rate) or told.rate * 20 * T < 1


@pytest.mark.parametrize("changes", [np.zeros((20, 4)), np.ones((3, 4))])
def test_nothing_or_too_little_is_not_told(changes):
    assert np.isnan(growth(changes, T).rate)
