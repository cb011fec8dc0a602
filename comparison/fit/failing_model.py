"""How much data count where a model fails: what it lacks is noise of its own, the same for neighbouring points.

Weighed as if every point were independent, a large misfit would outweigh whatever is known of parameters, and of the
offsets of single runs: they would go wherever they lessen it a little. So the residual, of mean square e, is taken for
noise of variance 1 and a discrepancy of variance e - 1, the same for m neighbours. The mean of n points then has the
variance (1 + m (e - 1)) / n: as if their noise were inflated by the root of n times that. How many neighbours these
are is a matter of how densely a curve was measured: what is missing is wrong over a stretch of it (`as_many`). Least
squares with the weights found anew at every step lower `unlikelihood`, whose derivative by chi2 the weight is (P. J.
Green, J. R. Stat. Soc. B 46 (1984) 149).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2 as chi_squared
from scipy.stats import f as ratio_of_variances

# Stretches of a curve in each of which what a model lacks is the same: it makes a resonance too high, too low, too wide
# on one side or the other.
STRETCHES = 4
# Chance that anything is said of data and a model that lack nothing.
RISK = 0.01
# Mean squared misfit beyond which a model fails badly: first order about it says little.
TOLERATED = 3.0


@dataclass(frozen=True)
class Freedom:
    """Degrees of freedom of a mean squared misfit.

    independent: values that count of their own. What little is wrong with a model, as a mesh, is the same for
        neighbouring points, so that these count for less (`as_one`); at least one counts
    noise: those of the variance that it is divided by, infinite where the noise is stated
    """

    independent: float
    noise: float = float("inf")

    @property
    def by_chance(self) -> Any:
        """Distribution (of scipy) of the mean squared misfit of a model that lacks nothing: of chi-square, or where the
        noise is itself an estimate of the ratio of two variances (R. A. Fisher, Proc. Int. Math. Congress Toronto 2
        (1924) 805)."""
        n = max(self.independent, 1.0)
        return chi_squared(n, scale=1 / n) if np.isinf(self.noise) else ratio_of_variances(n, self.noise)


def as_many(points: float) -> float:
    """Neighbours that count as one for what a model lacks, of a curve with so many points."""
    return max(points / STRETCHES, 1.0)


def as_one(as_many: float, common: float) -> float:
    """How many times fewer values count than there are: the mean of m neighbours has the variance (1 + m c) / m where
    they have c in common, that of the noise being 1 (as in `inflation`); at least one of them counts.

    common: c; infinite where it is not known, so that neighbours count as one
    """
    return float(min(1 + as_many * common, as_many)) if as_many > 1 else 1.0


def inflation(chi2: float, values: int, as_many: float) -> float:
    """Factor on the noise.

    chi2: sum of squares of so many values in standard deviations of the sensors; as_many: points that count as one for
        what the model lacks, 0 where it is taken to lack nothing
    """
    return float(np.sqrt(1 + as_many * max(chi2 / values - 1, 0.0)))


def unlikelihood(chi2: float, values: int, as_many: float) -> float:
    """Minus twice the logarithm of the probability of the data: chi2 up to a mean square of 1, its logarithm beyond."""
    if as_many == 0:
        return chi2
    beyond = max(chi2 / values - 1, 0.0)
    return min(chi2, float(values)) + values / as_many * float(np.log1p(as_many * beyond))
