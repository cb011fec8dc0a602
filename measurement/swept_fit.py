"""Harmonics of a signal whose frequency is swept without stops, in one window of it, by least squares.

x(t) = c0 + d t + sum_k Re((X_k + Y_k t) exp(i k p(t))), where p is the phase of the commanded frequency, its integral,
and t = 0 the middle of the window: X_k is what holds there, Y_k how fast it changes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.harmonic_fit import (
    HarmonicFit,
    blocks_of,
    check_clock,
    check_force,
    check_record,
    deviation_of,
)

Floats = NDArray[np.float64]
_PER_HARMONIC = 4  # real and imaginary part of X and of Y


def phase_of_sweep(time: Floats, frequency: Floats) -> Floats:
    """(n,) [rad] from the first sample on: the integral of the commanded frequency (n,) [Hz], trapezoidal."""
    turns = np.diff(time) * (frequency[1:] + frequency[:-1]) / 2
    return 2 * np.pi * np.append(0.0, np.cumsum(turns))


def fit_swept(time: Floats, signals: Floats, frequency: Floats, harmonics: Sequence[int]) -> HarmonicFit:
    """Amplitudes at the middle of the window. The frequency there is corrected from the drift of the force's phase.

    The deviation is the larger of that of white noise and the scatter of eight blocks of what is left, which sees how
    far the response is from changing linearly over the window.

    time: (n,) [s]; signals: (n_signals, n), the force first; frequency: (n,) as commanded [Hz]; harmonics: not 0
    raises: ValueError where the window is shorter than eight periods, is sampled too slowly for the harmonics, or its
        force has another frequency
    """
    middle, mean = float(time.mean()), float(frequency.mean())
    unknowns = 2 + _PER_HARMONIC * len(harmonics)
    check_record(time, mean, harmonics, unknowns)
    phase = phase_of_sweep(time, frequency)
    phase -= float(np.interp(middle, time, phase))
    A = _columns(time - middle, phase, harmonics)
    solution = np.linalg.lstsq(A, signals.T, rcond=None)[0]
    residual = signals - (A @ solution).T
    X, Y = (solution[2 + i :: _PER_HARMONIC] + 1j * solution[3 + i :: _PER_HARMONIC] for i in (0, 2))
    nominal = float(np.interp(middle, time, frequency))
    check_force(residual[0], signals[0], nominal)
    first = list(harmonics).index(1)
    drift = float((Y[first, 0] / X[first, 0]).imag) / (2 * np.pi)
    check_clock(drift, nominal)
    deviation = deviation_of(_left_by_blocks(phase, residual, harmonics), residual, unknowns)
    return HarmonicFit(X.T, deviation, nominal + drift)


def _columns(time: Floats, phase: Floats, harmonics: Sequence[int]) -> Floats:
    columns = [np.ones_like(time), time / np.ptp(time)]
    for k in harmonics:
        waves = np.cos(k * phase), -np.sin(k * phase)  # Re((a + ib) exp(i k p))
        columns += [*waves, *(time * wave for wave in waves)]
    return np.stack(columns, axis=1)


def _left_by_blocks(phase: Floats, residual: Floats, harmonics: Sequence[int]) -> NDArray[np.complex128]:
    """(n_blocks, n_signals, n_harmonics)"""
    waves = np.exp(-1j * np.outer(harmonics, phase))
    parts = blocks_of(len(phase))
    return np.array([2 * residual[:, part] @ waves[:, part].T / (part.stop - part.start) for part in parts])
