"""Harmonics of a settled time signal by least squares, with the error of doing so.

x(t) = c0 + d t + sum_k Re(X_k exp(i k w t)); the frequency is corrected from the drift of the excitation's phase, as
the clocks of generator and recorder differ (the four-parameter sine fit of IEEE Std 1057, by blocks).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

PERIODS = 8  # fewest that a fit with its error is made from
BLOCKS = 8
CLOCK_ERROR = 1e-3  # relative; more is no difference of clocks


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """amplitude: (n_signals, n_harmonics) peak values; deviation: the standard deviation of their real or imaginary
    part, same shape; frequency [Hz]: as corrected.

    Phases refer to the middle of the record, the mean of its times: there an error of the frequency does not turn them.
    """

    amplitude: Complex
    deviation: Floats
    frequency: float


def fit_harmonics(time: Floats, signals: Floats, frequency: float, harmonics: Sequence[int]) -> HarmonicFit:
    """Amplitudes at harmonics of the frequency, and its correction from the first signal, the force.

    The deviation is the larger of two: that of the least squares with white noise, and the scatter of eight blocks of
    the record, which sees what is not white (transients not yet settled, drift, beating).

    time: (n,) [s]; signals: (n_signals, n) in any unit; frequency: nominal [Hz]; harmonics: not 0

    raises: ValueError where the record is shorter than eight periods, is sampled too slowly for the harmonics, or its
        force has another frequency
    """
    unknowns = 2 + 2 * len(harmonics)
    check_record(time, frequency, harmonics, unknowns)
    time = time - time.mean()
    corrected = _corrected(time, signals[0], frequency)
    whole, residual = _least_squares(time, signals, corrected, harmonics)
    check_force(residual[0], signals[0], frequency)
    blocks = [_least_squares(time[part], signals[:, part], corrected, harmonics)[0] for part in blocks_of(len(time))]
    return HarmonicFit(whole, deviation_of(np.array(blocks), residual, unknowns), corrected)


def deviation_of(blocks: Complex, residual: Floats, unknowns: int) -> Floats:
    """(n_signals, n_harmonics) of a real or imaginary part: the larger of what amplitudes by blocks (n_blocks,
    n_signals, n_harmonics) scatter by and of white noise that leaves such a residual (n_signals, n)."""
    spread, n = blocks - np.mean(blocks, axis=0), residual.shape[1]
    by_blocks = np.sqrt(np.sum(np.abs(spread) ** 2, axis=0) / (2 * (BLOCKS - 1)) / BLOCKS)
    # Each part of X_k has the variance 2 s^2 / n where the columns are orthogonal: nearly so over many periods.
    white = np.sqrt(2 * np.sum(residual**2, axis=1) / (n - unknowns) / n)
    return np.asarray(np.maximum(by_blocks, white[:, None]))


def check_force(residual: Floats, force: Floats, frequency: float) -> None:
    """raises: ValueError where most of the force (n,) is left"""
    if float(np.var(residual)) > 0.5 * float(np.var(force)):
        raise ValueError(f"most of the force is not at {frequency:.6g} Hz, which is stated, nor at its harmonics")


def check_clock(drift: float, frequency: float) -> None:
    """drift: of the force's frequency from the one stated [Hz]. raises: ValueError where that is no error of clocks"""
    if abs(drift) > CLOCK_ERROR * frequency:
        raise ValueError(
            f"the force is not at {frequency:.6g} Hz, which is stated: its phase drifts through the record"
        )


def check_record(time: Floats, frequency: float, harmonics: Sequence[int], unknowns: int) -> None:
    """unknowns: of the fit, of which each block should have two samples. raises: ValueError"""
    steps = np.diff(time)
    if len(time) < 2 or not np.all(steps > 0):
        raise ValueError("time does not increase from sample to sample")
    duration = float(time[-1] - time[0])
    if duration * frequency < PERIODS:
        raise ValueError(
            f"{duration:.4g} s are {duration * frequency:.1f} periods of {frequency:g} Hz; {PERIODS} or more are wanted"
        )
    highest = max(harmonics)
    if float(np.max(steps)) * 2 * highest * frequency > 1:
        raise ValueError(
            f"{1 / float(np.max(steps)):.4g} samples a second (at the widest gap) are too few for harmonic {highest} "
            f"of {frequency:g} Hz: more than {2 * highest * frequency:.4g} are wanted"
        )
    if (each := len(time) // BLOCKS) < 2 * unknowns:
        raise ValueError(
            f"{len(time)} samples are too few for {len(harmonics)} harmonics ({each} in one of {BLOCKS} blocks)"
        )


def blocks_of(n: int) -> list[slice]:
    """As many parts of a record of n samples, one after the other."""
    edges = np.linspace(0, n, BLOCKS + 1).astype(int)
    return [slice(a, b) for a, b in pairwise(edges.tolist())]


def _least_squares(time: Floats, signals: Floats, frequency: float, harmonics: Sequence[int]) -> tuple[Complex, Floats]:
    """(n_signals, n_harmonics) amplitudes and (n_signals, n) what is left."""
    middle = float(time.mean())
    angle = 2 * np.pi * frequency * time
    columns = [np.ones_like(time), (time - middle) / (time[-1] - time[0])]
    for k in harmonics:
        columns += [np.cos(k * angle), -np.sin(k * angle)]  # Re((a + ib) exp(i k w t))
    A = np.stack(columns, axis=1)
    solution = np.linalg.lstsq(A, signals.T, rcond=None)[0]
    return (solution[2::2] + 1j * solution[3::2]).T, signals - (A @ solution).T


def _corrected(time: Floats, force: Floats, frequency: float) -> float:
    """Frequency from the drift of the force's phase over the blocks [Hz]."""
    start = frequency
    for _ in range(3):
        parts = blocks_of(len(time))
        amplitudes = [_least_squares(time[part], force[None, part], frequency, (1,))[0][0, 0] for part in parts]
        if not np.all(np.abs(amplitudes) > 0):
            raise ValueError("the force is zero over a part of the record")
        middles = np.array([time[part].mean() for part in parts])
        frequency += float(np.polyfit(middles, np.unwrap(np.angle(amplitudes)), 1)[0]) / (2 * np.pi)
    check_clock(frequency - start, start)
    return frequency
