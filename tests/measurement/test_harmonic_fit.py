"""Harmonics of time signals, and whether their stated error is the true one."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from updamp.measurement.harmonic_fit import fit_harmonics

RATE, F = 6000.0, 431.7
TIME = np.arange(3000) / RATE
AMPLITUDES = np.array([[17.0 * np.exp(0.5j), 0.0], [2e-3 * np.exp(-1.1j), 1e-4 * np.exp(2j)]])


MIDDLE = TIME.mean()
AT_MIDDLE = AMPLITUDES * np.exp(2j * np.pi * F * MIDDLE * np.array([1, 3]))


def signals(frequency: float = F) -> NDArray[np.float64]:
    phasors = np.exp(2j * np.pi * frequency * np.outer([1, 3], TIME))
    return np.real(AMPLITUDES @ phasors)


def test_exact_without_noise_whatever_offset_and_drift() -> None:
    drift = np.array([[3.0], [1e-4]]) + np.array([[1.0], [1e-3]]) * TIME
    fit = fit_harmonics(TIME, signals() + drift, F, (1, 3))
    np.testing.assert_allclose(fit.amplitude, AT_MIDDLE, atol=1e-9)
    assert fit.frequency == pytest.approx(F, abs=1e-9)


def test_clock_error_is_corrected() -> None:
    fit = fit_harmonics(TIME, signals(F + 0.21), F, (1, 3))
    assert fit.frequency == pytest.approx(F + 0.21, abs=1e-6)
    turned = AMPLITUDES * np.exp(2j * np.pi * (F + 0.21) * MIDDLE * np.array([1, 3]))
    np.testing.assert_allclose(fit.amplitude, turned, atol=1e-6)


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_stated_deviation_is_the_true_one(colour: float) -> None:
    """White noise, and noise with a memory that white statistics would get wrong near the excitation."""
    rng = np.random.default_rng(7)
    errors, stated = [], []
    for _ in range(150):
        noise = rng.normal(size=(2, len(TIME)))
        if colour:  # resonant at the excitation, with a correlation of some 20 samples
            pole = np.exp(2j * np.pi * F / RATE) * 0.95
            noise = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], noise, axis=1)
        fit = fit_harmonics(TIME, signals() + noise * np.array([[0.1], [1e-5]]), F, (1, 3))
        errors.append(fit.amplitude[1, 0] - AT_MIDDLE[1, 0])
        stated.append(fit.deviation[1, 0])
    true = np.sqrt(np.mean(np.abs(errors) ** 2) / 2)
    assert 0.85 < np.sqrt(np.mean(np.square(stated))) / true < 1.35


def test_a_transient_counts_as_error() -> None:
    ringing = 5e-4 * np.exp(-TIME / 0.15) * np.cos(2 * np.pi * (F + 6) * TIME)
    clean = fit_harmonics(TIME, signals(), F, (1, 3))
    fit = fit_harmonics(TIME, signals() + np.vstack([0 * TIME, ringing]), F, (1, 3))
    assert fit.deviation[1, 0] > 0.3 * abs(fit.amplitude[1, 0] - AT_MIDDLE[1, 0])
    assert fit.deviation[1, 0] > 1e4 * clean.deviation[1, 0]


@pytest.mark.parametrize(
    ("part", "frequency", "words"),
    [
        (slice(0, 40), F, "8 or more are wanted"),
        (slice(None), 1200.0, "samples a second"),
        (slice(None), F + 3.5, "not at 435.2 Hz"),
        (slice(None), F + 20, "not at 451.7 Hz"),
        (slice(None, None, -1), F, "does not increase"),
    ],
)
def test_records_that_cannot_be_fitted(part: slice, frequency: float, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        fit_harmonics(TIME[part], signals()[:, part], frequency, (1, 3))


def test_no_force() -> None:
    with pytest.raises(ValueError, match="the force is zero"):
        fit_harmonics(TIME, 0 * signals(), F, (1, 3))
