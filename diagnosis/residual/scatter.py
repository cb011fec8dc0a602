"""What differs from one assembly to the next, and from run to run: random offsets, their sizes learnt from the repeats.

The model is y = f(theta + b) with normal b for each assembly (a nonlinear mixed-effects model, linearised about the
offsets found: M. J. Lindstrom and D. M. Bates, Biometrics 46 (1990) 673). Offsets are those of the nuisance
parameters, a drift of frequency for each run and a gain for each sensor.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.optimize import minimize

from updamp.diagnosis.residual.matching import Matched

Floats = NDArray[np.float64]

DRIFT, GAIN, NOISE = "frequency drift", "sensor gain", "sensor noise"
# Standard deviations before the repeats have been looked at: relative, and of the logarithm of that guess.
_DRIFT, _GAIN = 1e-4, 0.01
_UNSURE, _UNSURE_NOISE = 0.5, 0.3
# No further from the guess than this many deviations: what would need more is a misfit, and no scatter.
_FURTHEST = 2.0
# Of an offset, in standard deviations.
_FARTHEST = 5.0


@dataclass(frozen=True)
class Scatter:
    """Standard deviations: of each nuisance parameter's logarithm from assembly to assembly, of the logarithm of a
    run's frequency, of that of a sensor's gain; noise: factor on the sensors' stated noise"""

    parameters: Mapping[str, float]
    drift: float = _DRIFT
    gain: float = _GAIN
    noise: float = 1.0

    def as_numbers(self) -> dict[str, float]:
        return {**self.parameters, DRIFT: self.drift, GAIN: self.gain, NOISE: self.noise}

    @staticmethod
    def of(numbers: Mapping[str, float]) -> "Scatter":
        rest = {name: value for name, value in numbers.items() if name not in (DRIFT, GAIN, NOISE)}
        return Scatter(rest, numbers[DRIFT], numbers[GAIN], numbers[NOISE])


@dataclass(frozen=True, eq=False)
class Assembly:
    """One repeat's equations: residual = common a + random b + noise of unit size.

    residual: (n,) at b = 0 to first order; common: (n, p) by the fitted parameters; random: (n, q) by the offsets
    kinds: (q,) name of the scatter that each offset belongs to
    """

    repeat: int
    residual: Floats
    common: Floats
    random: Floats
    kinds: tuple[str, ...]

    def deviations(self, scatter: Scatter) -> Floats:
        """(q,) of the offsets, in units of the sensors' noise"""
        numbers = scatter.as_numbers()
        return np.array([numbers[kind] for kind in self.kinds]) / scatter.noise


@dataclass(frozen=True, eq=False)
class Offsets:
    """One assembly's: parameters (p_nuisance,), drift of each run and gain of each sensor, by name."""

    parameters: Floats
    drift: Mapping[str, float]
    gain: Mapping[tuple[str, int], float]

    def correction(self, run: str, sensors: Sequence[tuple[str, int]]) -> Floats:
        """(m,) of the observations of one run"""
        correction = np.zeros(1 + 2 * len(sensors))
        correction[0] = self.drift.get(run, 0.0)
        correction[1::2] = [self.gain.get(sensor, 0.0) for sensor in sensors]
        return correction


def assembly(
    repeat: int,
    matched: Sequence[Matched],
    sensors: Sequence[Sequence[tuple[str, int]]],
    nuisances: Sequence[str],
    offsets: Offsets,
) -> Assembly:
    """The equations of one repeat from its matched runs; sensors: of each run's condition."""
    runs = [m.observations.run for m in matched]
    gains = list(dict.fromkeys(sensor for of_run in sensors for sensor in of_run))
    kinds = (*nuisances, *(DRIFT for _ in runs), *(GAIN for _ in gains))
    blocks, residual, common = [], [], []
    for i, (m, of_run) in enumerate(zip(matched, sensors, strict=True)):
        n = m.residual.size
        block = np.zeros((n, len(kinds)))
        block[:, : len(nuisances)] = m.by_parameter.reshape(n, -1)[:, : len(nuisances)]
        block[:, len(nuisances) + i] = m.by_observation[:, :, 0].ravel()
        for j, sensor in enumerate(of_run):
            place = len(nuisances) + len(runs) + gains.index(sensor)
            block[:, place] = m.by_observation[:, :, 1 + 2 * j].ravel()
        b = np.concatenate(
            [
                offsets.parameters,
                [offsets.drift.get(run, 0.0) for run in runs],
                [offsets.gain.get(sensor, 0.0) for sensor in gains],
            ]
        )
        blocks.append(block)
        residual.append(m.residual.ravel() + block @ b)
        common.append(m.by_parameter.reshape(n, -1))
    return Assembly(repeat, np.concatenate(residual), np.concatenate(common), np.concatenate(blocks), kinds)


def split(b: Floats, matched: Sequence[Matched], sensors: Sequence[Sequence[tuple[str, int]]], n: int) -> Offsets:
    """The offsets of one assembly from their vector; n: nuisance parameters."""
    runs = [m.observations.run for m in matched]
    gains = list(dict.fromkeys(sensor for of_run in sensors for sensor in of_run))
    drift = dict(zip(runs, b[n : n + len(runs)].tolist(), strict=True))
    return Offsets(b[:n], drift, dict(zip(gains, b[n + len(runs) :].tolist(), strict=True)))


def learn(assemblies: Sequence[Assembly], prior: Scatter, free: int) -> Scatter:
    """The scatter that makes the repeats most likely (restricted to what the fitted parameters leave), with each size
    lognormal about its prior. From a single assembly only the noise is learnt.

    free: number of fitted parameters, taken off the freedom of the noise
    """
    names = list(prior.as_numbers())
    start = np.log([prior.as_numbers()[name] for name in names])
    sizes = np.array([_UNSURE_NOISE if name == NOISE else _UNSURE for name in names])
    products = [_Products.of(a) for a in assemblies]

    def unlikely(z: Floats) -> float:
        scatter = Scatter.of(dict(zip(names, np.exp(start + sizes * z), strict=True)))
        total = float(z @ z)
        for a, p in zip(assemblies, products, strict=True):
            total += p.minus_twice_log_likelihood(a.deviations(scatter), scatter.noise, free / len(assemblies))
        return total

    # one assembly does not tell what the next would differ by
    alone = len(assemblies) < 2
    bounds = [(0.0, 0.0) if alone and name != NOISE else (-3.0, 3.0) for name in names]
    found = minimize(unlikely, np.zeros(len(names)), method="L-BFGS-B", bounds=bounds)
    return Scatter.of(dict(zip(names, np.exp(start + sizes * found.x).tolist(), strict=True)))


@dataclass(frozen=True, eq=False)
class _Products:
    """rr: r^T r; Rr: R^T r; RR: R^T R, of the residual r with the fitted parameters' part taken off and random R"""

    n: int
    rr: float
    Rr: Floats
    RR: Floats

    @staticmethod
    def of(a: Assembly) -> "_Products":
        return _Products(
            len(a.residual), float(a.residual @ a.residual), a.random.T @ a.residual, a.random.T @ a.random
        )

    def minus_twice_log_likelihood(self, deviations: Floats, noise: float, free: float) -> float:
        inner = np.eye(len(deviations)) + deviations[:, None] * self.RR * deviations
        factor = scipy.linalg.cho_factor(inner)
        part = deviations * self.Rr
        chi2 = (self.rr - part @ scipy.linalg.cho_solve(factor, part)) / noise**2
        log_determinant = 2 * np.sum(np.log(np.diag(factor[0])))
        return float(chi2 + log_determinant + 2 * (self.n - free) * np.log(noise))


def offsets_of(a: Assembly, scatter: Scatter) -> tuple[Floats, float]:
    """The likeliest offsets (q,) of one assembly with the common part taken off, and its chi2: r^T C^-1 r."""
    deviations = a.deviations(scatter)
    inner = np.eye(len(deviations)) + deviations[:, None] * (a.random.T @ a.random) * deviations
    b = deviations * scipy.linalg.solve(inner, deviations * (a.random.T @ a.residual), assume_a="pos")
    rest = a.residual - a.random @ b
    chi2 = float(a.residual @ rest) / scatter.noise**2
    return b, chi2


def within_reach(b: Floats, a: Assembly, scatter: Scatter) -> Floats:
    """The offsets no further off than an assembly can be: a model that fails grossly is not excused by them."""
    farthest = _FARTHEST * a.deviations(scatter) * scatter.noise
    return np.clip(b, -farthest, farthest)


def whitened(a: Assembly, scatter: Scatter) -> tuple[Floats, Floats]:
    """C^-1/2 of the residual (n,) and of the common columns (n, p): what least squares sees."""
    deviations = a.deviations(scatter)
    left, sizes, _ = np.linalg.svd(a.random * deviations, full_matrices=False)
    shrink = 1 / np.sqrt(1 + sizes**2) - 1

    def root(values: Floats) -> Floats:
        spread = left.T @ values
        return np.asarray((values + left @ (shrink * spread.T).T) / scatter.noise)

    return root(a.residual), root(a.common)
