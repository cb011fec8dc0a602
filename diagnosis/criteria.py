"""What a verdict is decided by, and how far the search goes. All of it is fixed before a benchmark is scored.

The mean squared misfit is chi-square over the number of measured values: 1 is what the scatter leaves.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from updamp.comparison.fit.failing_model import Freedom


@dataclass(frozen=True)
class SearchEffort:
    """How many fits a search makes, and where it stops.

    score: of the score test, below which an effect is not looked for in the data
    short, full: how many effects at most get a short refit, and a full one
    close: mean squared misfit after a short refit, over that of the best one, up to which an effect gets a full one
    nearly: share of the best effect's fall of mean squared misfit from which on another one is fitted in full too, and
        the next one has second effects looked for beside it
    comparable: mean squared misfit, over that of the best one, beyond which it does not count as nearly as good
    promising: share of the misfit left by a short refit from where on the full one is done before others are tried
    starts: pairs from which three and more effects are looked for, until they explain the data
    """

    score: float = 4.0
    short: int = 6
    full: int = 3
    close: float = 1.6
    nearly: float = 0.8
    comparable: float = 4.0
    promising: float = 0.2
    starts: int = 2


@dataclass(frozen=True)
class Criteria:
    """chance: probability with which a model that lacks nothing is as far off as one that is said to fail, and any of
        its calibrated parameters, drifts and gains as far from what is stated as one that is said to be in the way of
        a verdict; one in 370, three deviations of a normal distribution
    doubtful: likewise, from where on more is looked for than what has been found
    visibility: share of an effect's signature that the nuisance parameters cannot imitate, below which it is looked for
        and named only where the score test sees something of that share
    delta_bic: by which an effect has to improve the information criterion, twice the logarithm of the odds (10: 150 to
        1), the misfit that is left taken as noise
    gain: share by which the error on held-out runs has to fall
    at_bound: distance from a bound, as a share of its range, within which a parameter stands at it
    as_good: share that mean squared misfits have to differ by, or they are the same
    cosine: of two signatures above which the effects look alike
    search: how far the search goes
    """

    chance: float = 0.0027
    doubtful: float = 0.05
    visibility: float = 0.2
    delta_bic: float = 10.0
    gain: float = 0.03
    at_bound: float = 0.005
    as_good: float = 0.1
    cosine: float = 0.9
    search: SearchEffort = field(default_factory=SearchEffort)

    def calibration(self, values: int) -> float:
        """Prior deviations that any of so many independent values exceeds, to either side, with the probability
        `chance`: 3 of one, 3.9 of thirty (Z. Sidak, J. Am. Stat. Assoc. 62 (1967) 626)."""
        of_each = -np.expm1(np.log1p(-self.chance) / values)
        return float(norm.isf(of_each / 2))

    def is_far_off(self, deviations: float, values: int) -> bool:
        """Whether nobody would believe that the farthest of so many values is so many prior deviations from where it
        was stated to be."""
        return abs(deviations) >= self.calibration(values)

    def fails(self, misfit: float, freedom: Freedom) -> bool:
        """Whether a mean squared misfit is no chance; never of no values (nan)."""
        return misfit > largest_by_chance(freedom, self.chance)

    def is_doubtful(self, misfit: float, freedom: Freedom) -> bool:
        """Likewise, whether it may be none."""
        return misfit > largest_by_chance(freedom, self.doubtful)


def largest_by_chance(freedom: Freedom, probability: float) -> float:
    """Mean squared misfit that a model which lacks nothing exceeds with this probability."""
    return float(freedom.by_chance.isf(probability))
