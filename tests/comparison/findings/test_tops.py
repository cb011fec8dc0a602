"""Tops that chance does not make: on a flank there is none, whatever the noise does."""

import numpy as np
import pytest

from updamp.comparison.findings.backbone import read_resonance
from updamp.comparison.findings.tops import highest, tops

NOISE = 0.02


def flank(seed: int, high: float = 59.6) -> tuple[np.ndarray, np.ndarray]:
    """A resonance at 60 Hz with a loss factor of 0.01, measured up to a frequency below it, and 2 % of noise"""
    rng, f = np.random.default_rng(seed), np.linspace(57.5, high, 31)
    exact = 1 / (60.0**2 * (1 + 0.01j) - f**2)
    return f, exact * np.exp(NOISE * (rng.standard_normal(31) + 1j * rng.standard_normal(31)))


def test_a_flank_has_no_top() -> None:
    bumps = []
    for seed in range(40):
        f, receptance = flank(seed)
        log_size, deviation = np.log(np.abs(receptance)), np.full(31, NOISE)
        assert len(tops(log_size, deviation)[0]) == 0
        assert highest(log_size, deviation) == int(np.argmax(log_size))
        found = read_resonance(f, receptance, np.ones(31), deviation)
        assert found.frequency > 59.4
        assert np.isnan(found.loss_factor)
        bumps.append(len(tops(log_size)[0]))
    assert np.median(bumps) >= 1, "the noise makes bumps of its own"


@pytest.mark.parametrize("seed", range(10))
def test_a_resonance_below_a_flank_is_the_top(seed: int) -> None:
    """At the end the curve climbs to another mode's resonance, ten times as high."""
    rng, f = np.random.default_rng(seed), np.linspace(58, 64.9, 60)
    exact = 1 / (60.0**2 * (1 + 0.01j) - f**2) + 10 / (65.0**2 * (1 + 0.01j) - f**2)
    log_size = np.log(np.abs(exact)) + NOISE * rng.standard_normal(60)
    assert log_size[-1] > np.log(np.abs(exact))[np.argmin(abs(f - 60))]
    assert abs(f[highest(log_size, np.full(60, NOISE))] - 60) < 0.3


def test_a_top_of_two_equal_values_is_one() -> None:
    size = np.log(np.array([1.0, 2, 4, 4, 3, 1]))
    assert tops(size)[0].tolist() in ([2], [3])
    assert tops(np.log(np.array([8.0, 5, 5, 3, 1])))[0].size == 0
