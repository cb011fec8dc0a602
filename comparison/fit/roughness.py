"""The sensors' noise where it is not stated: how rough runs are, and how well few points of single runs tell it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Points of a run that its roughness is told from.
_FEWEST = 8
# Of an amplitude where nothing is stated and too little is measured to tell.
_AMPLITUDE = 0.01
# Third quartile of the normal distribution: half of all deviations lie within it.
_QUARTILE = 0.67449
# Of the variances of four neighbours in that of their third difference, (a - 3 b + 3 c - d) / sqrt(20).
SHARES = np.array([1.0, 9.0, 9.0, 1.0]) / 20
# Relative standard deviation of a roughness times the root of the number n of third differences. The median of the
# absolute values of n independent ones has 1 / (4 q f(q)) = 1.1664, q the quartile and f the normal density there.
# Third differences of noise have autocorrelations of -0.75, 0.3 and -0.05; the indicators of "within the quartile" then
# have 0.300, 0.035 and 0.001, and the variance of their mean is 1 + 2 (0.300 + 0.035 + 0.001) = 1.672 times that.
KNOWN_FROM_ONE = 1.508


def roughness(values: Floats) -> float:
    """Standard deviation of the noise on a smooth run of values."""
    third = third_differences(values)
    return max(deviation_of(third), 1e-4) if len(third) else _AMPLITUDE


def third_differences(values: Floats) -> Floats:
    """Of a smooth run of values, scaled to the standard deviation of its noise; none of a run too short to tell."""
    return np.diff(values, 3) / np.sqrt(20) if len(values) >= _FEWEST else np.zeros(0)


def deviation_of(normal: Floats) -> float:
    """Standard deviation by the median, which is not drawn up by the few places where a run itself is not smooth."""
    return float(np.median(np.abs(normal)) / _QUARTILE)


def known_to(points: int) -> float:
    """Standard deviation of the logarithm of a run's roughness: 0.25 of forty points, 0.44 of fifteen."""
    return float(KNOWN_FROM_ONE / np.sqrt(max(points, _FEWEST) - 3))


def freedom(points: Sequence[int]) -> float:
    """Degrees of freedom of the variance read off runs of so many points by those third differences that are no
    outliers: of n of them, with the autocorrelations above, the mean square has the relative variance
    2 (1 + 2 (0.75^2 + 0.3^2 + 0.05^2)) / n = 4.62 / n, and that of f degrees of freedom is 2 / f."""
    return max(sum(n - 3 for n in points if n >= _FEWEST) / 2.31, 1.0)


def shrunk(logarithms: Floats, points: Sequence[int]) -> Floats:
    """(n,) logarithms of the roughness of runs of one sensor, drawn towards what they have in common.

    That of one run is known to a quarter or worse, and weights made of it would be off by half. How much the runs
    really differ is what is left of their spread (empirical Bayes: C. N. Morris, J. Am. Stat. Assoc. 78 (1983) 47).
    Fewer than three runs stay as they are.

    points: of each run
    """
    if len(logarithms) < 3:
        return logarithms
    spread = float(np.var(logarithms, ddof=1))
    by_chance = float(np.mean([known_to(n) ** 2 for n in points]))
    real = max(0.0, 1 - by_chance / spread) if spread > 0 else 0.0
    centre = np.median(logarithms)
    return np.asarray(centre + real * (logarithms - centre))
