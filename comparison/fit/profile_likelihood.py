"""The 95 % interval of one parameter, by what else the data would have to be if it were held elsewhere.

All other parameters are fitted anew at each value that it is held at (profile likelihood: D. M. Bates and D. G. Watts,
Nonlinear Regression Analysis and Its Applications (1988), section 6.1). Derivatives where a fit ends tell the width of
its own dent alone: where contacts begin to slip one after the other chi-square is uneven, and a fit that ends in one of
several dents is surer of it than the data are.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import Compared, compare_at, objective, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.fit_round import step_limits
from updamp.comparison.fit.linear_fit import fit_within
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.hbm.continuation.continuation import BranchStoppedError

Floats = NDArray[np.float64]

# Two-sided 95 % of a normal distribution, in its deviations.
_95 = 1.96


@dataclass(frozen=True)
class ProfileOptions:
    """farther: how often at most it is held farther out to one side, each time twice as far from the fit, until the
    data speak against it
    reach: of the other parameters, as `FitOptions.largest_step`
    noise: share of it that branches are interpolated by: values of a mean error e, in their deviations, move chi-square
        by n e^2, give or take 2 sqrt(n) e; as a fit has them (e of 0.05) by 4 +- 4 for 1,500, so 0.2 +- 1, where an
        interval ends at a rise of 3.84
    """

    farther: int = 3
    reach: float = 0.5
    noise: float = 0.25


@dataclass(frozen=True, eq=False)
class Profile:
    """u: (k,) ascending, what the parameter was held at; rise: (k,) of chi-square above the least of them, as far as it
    counts where what finer numerics change is among the unknowns (`Fit.covariance_told`)
    """

    u: Floats
    rise: Floats

    @property
    def told(self) -> tuple[bool, bool]:
        """Whether the data speak against the first and the last of these, so that the interval ends before them"""
        return bool(self.rise[0] >= _95**2), bool(self.rise[-1] >= _95**2)

    @property
    def interval(self) -> tuple[float, float]:
        """Where the signed root of the rise, which is nearly linear (ibid., profile t), comes to what 95 % lie within;
        beyond, where that is not reached."""
        root, least = np.sqrt(self.rise), int(np.argmin(self.rise))
        below, above = slice(least, None, -1), slice(least, None)
        return _crossing(self.u[below], root[below]), _crossing(self.u[above], root[above])


def _crossing(u: Floats, root: Floats) -> float:
    """From the least outwards: the last crossing, since an interval has no holes."""
    inside = np.flatnonzero(root < _95)
    last = int(inside[-1])
    if last == len(u) - 1:
        return float(u[-1])
    share = (_95 - root[last]) / (root[last + 1] - root[last])
    return float(u[last] + share * (u[last + 1] - u[last]))


def _ready(found: Fit, plan: Plan, branches_of: Branches) -> Fit:
    """With the numerical error as it is where the fit ends, and branches that are traced with it.

    Its derivatives hold as far as to the next contact that begins to slip in one of the models: carried on to where the
    parameter is held they made chi-square 10 higher in one of two fits that had asked for them at the same place (fits
    of 001 of the draw 82059009, two deviations away).
    """
    p, c = found.parametrisation, found.compared
    there = replace(p, numerics=p.numerics.held_at(found.u))
    branches = predict_branches(there, found.u, plan, None, branches_of)
    return replace(found, parametrisation=there, compared=replace(c, branches=branches))


def profile(
    found: Fit, plan: Plan, place: int, branches_of: Branches = in_turn, options: ProfileOptions = ProfileOptions()
) -> Profile:
    """From bound to bound of one that the data do not tell at all.

    plan: of the fit's runs; place: of the parameter in u
    raises: BranchStoppedError where the model has no response at the fit itself
    """
    if not found.covariance[place, place] > 0:
        p = found.parametrisation
        return Profile(np.array([p.lower[place], found.u[place], p.upper[place]]), np.zeros(3))
    work = _Work(_ready(found, plan, branches_of), plan, place, branches_of, options)
    here = work.held(float(found.u[place]))
    chain = [*reversed(work.outwards(here, -1)), here, *work.outwards(here, 1)]
    values = np.array([objective(found.parametrisation, c) for c in chain])
    rise = work.counts * (values - values.min())
    return Profile(np.array([c.u[place] for c in chain]), rise)


@dataclass(frozen=True, eq=False)
class _Work:
    """What all values have in common, as `profile` is given it; the fit with its branches."""

    found: Fit
    plan: Plan
    place: int
    branches_of: Branches
    options: ProfileOptions

    @property
    def counts(self) -> float:
        """Share of a rise of chi-square that the data tell"""
        return float((self.found.deviations[self.place] / self.found.uncertainty[self.place]) ** 2)

    def outwards(self, here: Compared, side: int) -> list[Compared]:
        """To one side, until the data speak against it"""
        p, j = self.found.parametrisation, self.place
        step, bound = _95 * self.found.uncertainty[j], (p.lower if side < 0 else p.upper)[j]
        chain, least = [here], objective(p, here)
        for times in (2.0**i for i in range(self.options.farther + 1)):
            value = float(np.clip(here.u[j] + side * times * step, p.lower[j], p.upper[j]))
            try:
                chain.append(self.held(value))
            except BranchStoppedError:
                break
            least = min(least, objective(p, chain[-1]))
            if value == bound or self.counts * (objective(p, chain[-1]) - least) >= _95**2:
                break
        return chain[1:]

    def held(self, value: float) -> Compared:
        """All others where they are likeliest with it, to first order about where that leads from the fit.

        At every value, the fit's own among them, branches are moved from the same points: chi-square differs by what is
        between points, too.
        """
        f, p, c, j = self.found, self.found.parametrisation, self.found.compared, self.place
        u = np.clip(f.u + f.covariance[:, j] / f.covariance[j, j] * (value - f.u[j]), p.lower, p.upper)
        u[j] = value
        noise = self.options.noise * c.inflation
        branches = predict_branches(p, u, self.plan, c.branches, self.branches_of, inflation=noise)
        solved = compare_at(p, u, self.plan, branches, c.scatter, c.offsets)
        lower, upper = step_limits(p, u, self.options.reach)
        lower[j] = upper[j] = value
        return fit_within(p, self.plan, solved, lower, upper)
