"""What differs from one assembly to the next, and from run to run: random offsets, their sizes learnt from the repeats.

The model is y = f(theta + b) with normal b for each assembly (a nonlinear mixed-effects model, linearised about the
offsets found: M. J. Lindstrom and D. M. Bates, Biometrics 46 (1990) 673). Offsets are those of the nuisance
parameters, a drift of frequency and a level for each run, a gain for each sensor, and of identified modes the entries
of their shapes (`offsets.py`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from updamp.measurement import measurement

Floats = NDArray[np.float64]

DRIFT, LEVEL, GAIN, SHAPE, NOISE = "frequency drift", "level of a run", "sensor gain", "mode shape", "sensor noise"
# Standard deviations of the logarithms: of what is stated of the instruments; of what calibrated parameters are assumed
# to scatter by, an engineer's reading before a rig has been put together twice; of the sensors' noise.
_UNSURE, _UNSURE_PARAMETER, _UNSURE_NOISE = 0.5, 1.0, 0.3
# No further from the guess than this many deviations while a fit is under way: what would need more is a misfit, and no
# scatter. Where a misfit is left out of it beforehand only the noise is held so.
_FURTHEST = 2.0
# Times the stated noise that can be learnt.
MOST_NOISE = float(np.exp(_FURTHEST * _UNSURE_NOISE))


@dataclass(frozen=True)
class Scatter:
    """Standard deviations: of each nuisance parameter's logarithm from assembly to assembly, of the logarithm of a
    run's frequency, of that of a sensor's gain, of that of all amplitudes of a run; noise: factor on the sensors'
    stated noise; shape: of what a mode identified in a test moves by at a point, over its largest, as a modal analysis
    of one structure repeats"""

    parameters: Mapping[str, float]
    drift: float = measurement.DRIFT
    gain: float = measurement.GAIN
    level: float = measurement.LEVEL
    noise: float = 1.0
    shape: float = 0.01

    def as_numbers(self) -> dict[str, float]:
        of_test = {DRIFT: self.drift, GAIN: self.gain, LEVEL: self.level, SHAPE: self.shape, NOISE: self.noise}
        return {**self.parameters, **of_test}

    def inflated(self, factor: float) -> "Scatter":
        """With so many times the noise."""
        return replace(self, noise=factor * self.noise)

    @staticmethod
    def of(numbers: Mapping[str, float]) -> "Scatter":
        of_test = DRIFT, GAIN, LEVEL, NOISE, SHAPE
        rest = {name: value for name, value in numbers.items() if name not in of_test}
        return Scatter(rest, *(numbers[name] for name in of_test))


@dataclass(frozen=True, eq=False)
class Assembly:
    """One repeat's equations: residual = common a + random b + noise of unit size.

    residual: (n,) at b = 0 to first order; common: (n, p) by the fitted parameters; random: (n, q) by the offsets
    kinds: (q,) name of the scatter that each offset belongs to; offsets: (q,) about which the equations were made
    """

    repeat: int
    residual: Floats
    common: Floats
    random: Floats
    kinds: tuple[str, ...]
    offsets: Floats

    def deviations(self, scatter: Scatter) -> Floats:
        """(q,) of the offsets, in units of the sensors' noise"""
        numbers = scatter.as_numbers()
        return np.array([numbers[kind] for kind in self.kinds]) / scatter.noise


def kinds_of(assemblies: Sequence[Assembly]) -> set[str]:
    """Of the sizes that these assemblies have offsets, and noise, of: no shapes where none was identified"""
    return {NOISE}.union(*(a.kinds for a in assemblies))


def how_unsure(name: str) -> float:
    """Standard deviation of the logarithm of one size of the scatter, before the repeats are looked at."""
    stated = dict.fromkeys((DRIFT, GAIN, LEVEL, SHAPE), _UNSURE)
    return {NOISE: _UNSURE_NOISE, **stated}.get(name, _UNSURE_PARAMETER)


def learn(assemblies: Sequence[Assembly], prior: Scatter, furthest: float = _FURTHEST) -> Scatter:
    """The scatter that makes the differences between the repeats most likely, with each size lognormal about its prior.

    Restricted maximum likelihood (H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545): the fitted parameters
    may be anything meanwhile, so that what all repeats have in common is no scatter. Of a single assembly the sensors'
    noise alone is learnt: what else differs from run to run there is what the model gets wrong.

    furthest: deviations from the prior at most; the noise's is `MOST_NOISE` at most in any case
    """
    stated = prior.as_numbers()
    names = [name for name in stated if name in kinds_of(assemblies)] if len(assemblies) > 1 else [NOISE]
    start = np.log([stated[name] for name in names])
    sizes = np.array([how_unsure(name) for name in names])
    products = [_Products.of(a) for a in assemblies]

    def unlikely(z: Floats) -> float:
        scatter = Scatter.of({**stated, **dict(zip(names, np.exp(start + sizes * z), strict=True))})
        pairs = zip(assemblies, products, strict=True)
        parts = [p.reduced(a.deviations(scatter), scatter.noise) for a, p in pairs]
        chi2, right, information, log_determinant = (sum(column) for column in zip(*parts, strict=True))
        # directions that these data say nothing of are left alone
        values, vectors = np.linalg.eigh(information)
        informed = values > 1e-8 * values[-1]
        free = (vectors[:, informed].T @ right) ** 2 / values[informed]
        return float(z @ z + chi2 - free.sum() + log_determinant + np.log(values[informed]).sum())

    most = np.array([_FURTHEST if name == NOISE else furthest for name in names])
    found = minimize(unlikely, np.zeros(len(names)), method="L-BFGS-B", bounds=Bounds(-most, most))
    return Scatter.of({**stated, **dict(zip(names, np.exp(start + sizes * found.x).tolist(), strict=True))})


@dataclass(frozen=True, eq=False)
class _Products:
    """Of the residual r, the random columns R and the common ones C.

    n: length of r; RR: R^T R; crossed: R^T [r C]; squared: [r C]^T [r C]
    """

    n: int
    RR: Floats
    crossed: Floats
    squared: Floats

    @staticmethod
    def of(a: Assembly) -> "_Products":
        both = np.column_stack([a.residual, a.common])
        return _Products(len(a.residual), a.random.T @ a.random, a.random.T @ both, both.T @ both)

    def reduced(self, deviations: Floats, noise: float) -> tuple[float, Floats, Floats, float]:
        """r^T V^-1 r, C^T V^-1 r, C^T V^-1 C and log det V of the covariance V."""
        inner = np.eye(len(deviations)) + deviations[:, None] * self.RR * deviations
        factor = scipy.linalg.cho_factor(inner)
        part = deviations[:, None] * self.crossed
        all_ = (self.squared - part.T @ scipy.linalg.cho_solve(factor, part)) / noise**2
        log_determinant = 2 * float(np.sum(np.log(np.diag(factor[0])))) + 2 * self.n * np.log(noise)
        return float(all_[0, 0]), all_[1:, 0], all_[1:, 1:], log_determinant


def offsets_of(a: Assembly, scatter: Scatter) -> tuple[Floats, float]:
    """The likeliest offsets (q,) of one assembly with the common part taken off, and its chi2: r^T C^-1 r."""
    deviations = a.deviations(scatter)
    inner = np.eye(len(deviations)) + deviations[:, None] * (a.random.T @ a.random) * deviations
    b = deviations * scipy.linalg.solve(inner, deviations * (a.random.T @ a.residual), assume_a="pos")
    rest = a.residual - a.random @ b
    chi2 = float(a.residual @ rest) / scatter.noise**2
    return b, chi2


def parts_of_chi2(a: Assembly, scatter: Scatter) -> tuple[float, float]:
    """What is left with the offsets about which the equations were made, and the offsets' own share."""
    left, share = a.residual - a.random @ a.offsets, standing(a, scatter)
    return float(left @ left) / scatter.noise**2, float(share @ share)


def standing(a: Assembly, scatter: Scatter) -> Floats:
    """(q,) how many of their standard deviations the offsets are."""
    return a.offsets / (a.deviations(scatter) * scatter.noise)


def whitened(a: Assembly, scatter: Scatter) -> tuple[Floats, Floats]:
    """C^-1/2 of the residual (n,) and of the common columns (n, p): what least squares sees."""
    deviations = a.deviations(scatter)
    left, sizes, _ = np.linalg.svd(a.random * deviations, full_matrices=False)
    shrink = 1 / np.sqrt(1 + sizes**2) - 1

    def root(values: Floats) -> Floats:
        spread = left.T @ values
        return np.asarray((values + left @ (shrink * spread.T).T) / scatter.noise)

    return root(a.residual), root(a.common)
