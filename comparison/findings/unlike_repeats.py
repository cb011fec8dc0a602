"""Runs that are unlike their repeats: a sensor that came loose, a sweep that was disturbed.

The repeats of a test are z = c + R b + e: c is what the model gets wrong, anything but common to all of them, b the
offsets of each run with the scatter that is known of them, and e noise. The offsets are each run's own here, though an
assembly's are the same in all its tests: what they do to a test is known to first order only. With P the inverse of the
covariance of z projected off c, a run that is left out differs from what the others predict by P_ii^-1 (P z)_i, of
covariance P_ii^-1 (R. Christensen, L. M. Pearson, W. Johnson, Technometrics 34 (1992) 38). Its square is held against
what the others leave, no less than the noise, in an F-test. Two repeats do not tell which of them is to be looked at.

As for what a model lacks, values count as one over a quarter of the curve (`comparison/fit/failing_model.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from updamp.comparison.comparison import UnlikeRun
from updamp.comparison.findings.words import level_of
from updamp.comparison.fit.at_sensors import to_sensors
from updamp.comparison.fit.compared import Compared
from updamp.comparison.fit.failing_model import RISK, STRETCHES
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter

Floats = NDArray[np.float64]
# Fewest repeats of which one can be told from the others.
FEWEST = 3


def unlike_repeats(compared: Compared, scatter: Scatter, plan: Plan) -> tuple[UnlikeRun, ...]:
    """The least likely first; none where there are fewer than three repeats. Repeats that differ by chance alone have
    any run named with a probability of `RISK`.

    scatter: that the repeats alone show, since a model that fails is fitted with more
    """
    tested = [
        UnlikeRun(condition.name, condition.mode, level_of(plan, test), run.repeat, times, chance)
        for test, condition in enumerate(plan.conditions)
        for run, times, chance in _off(_repeats(compared, scatter, test))
    ]
    return tuple(sorted((run for run in tested if run.chance * len(tested) < RISK), key=lambda run: run.chance))


@dataclass(frozen=True, eq=False)
class _Run:
    """values: (d,) means over stretches of the branch of what the model leaves, in deviations of the sensors
    covariance: (d, d) of them by noise and offsets"""

    repeat: int
    values: Floats
    covariance: Floats


def _off(runs: Sequence[_Run]) -> Iterator[tuple[_Run, float, float]]:
    """How many times the scatter each is off, and the probability of as much by chance."""
    if len(runs) < FEWEST or not len(runs[0].values):
        return
    projected, values = _projected(runs), np.concatenate([run.values for run in runs])
    off = projected @ values
    n, d = len(runs), len(runs[0].values)
    for i, run in enumerate(runs):
        own = slice(i * d, (i + 1) * d)
        squared = float(off[own] @ np.linalg.solve(projected[own, own], off[own]))
        among = (float(values @ off) - squared) / (d * (n - 2))
        ratio = squared / d / max(among, 1.0)
        yield run, ratio**0.5, float(f_distribution.sf(ratio, d, d * (n - 2)))


def _projected(runs: Sequence[_Run]) -> Floats:
    """P = V^-1 - V^-1 C (C' V^-1 C)^-1 C' V^-1: of the covariance V, with the columns C of what is common."""
    inverses = [np.linalg.inv(run.covariance) for run in runs]
    of_common = np.concatenate(inverses)
    projected = -of_common @ np.linalg.solve(np.sum(inverses, axis=0), of_common.T)
    d = len(inverses[0])
    for i, inverse in enumerate(inverses):
        projected[i * d : (i + 1) * d, i * d : (i + 1) * d] += inverse
    return np.asarray(projected)


def _repeats(compared: Compared, scatter: Scatter, test: int) -> list[_Run]:
    """Of a test; over stretches with as many points of all of them, where each has some."""
    of_test = [m for m in compared.matched if m.observations.test == test]
    if len(of_test) < FEWEST:
        return []
    edges = np.quantile(np.concatenate([m.place for m in of_test]), np.linspace(0, 1, STRETCHES + 1)[1:-1])
    within = [np.digitize(m.place, edges)[:, None] == np.arange(STRETCHES) for m in of_test]
    points = np.array([each.sum(axis=0) for each in within])
    kept = np.flatnonzero(points.min(axis=0))
    return [
        _reduced(compared, scatter, m, each[:, kept] / n[kept])
        for m, each, n in zip(of_test, within, points, strict=True)
    ]


def _reduced(compared: Compared, scatter: Scatter, m: Matched, share: Floats) -> _Run:
    """share: (n, stretches) of each point in the mean of its stretch"""
    mean = np.einsum("ns,nrm->smnr", share, to_sensors(m))
    variance = np.repeat(np.sum(share**2, axis=0), mean.shape[1])
    mean = mean.reshape(-1, m.residual.size)
    (a,) = (a for a in compared.assemblies if a.repeat == m.observations.repeat)
    rows = _rows(compared, m)
    offsets = mean @ a.random[rows] * a.deviations(scatter)
    values = mean @ a.residual[rows] / scatter.noise
    return _Run(a.repeat, values, np.diag(variance) + offsets @ offsets.T)


def _rows(compared: Compared, run: Matched) -> slice:
    """Of one run in the equations of its assembly."""
    of_assembly = [m for m in compared.matched if m.observations.repeat == run.observations.repeat]
    start = sum(m.residual.size for m in of_assembly[: of_assembly.index(run)])
    return slice(start, start + run.residual.size)
