"""Fit the parameters of a model to a measurement, and see what is left.

Two loops (M. J. Lindstrom and D. M. Bates, Biometrics 46 (1990) 673): inside, the branches are taken as linear in the
parameters about where they were solved, while parameters, the offsets of each assembly and the scatter are fitted;
outside, the branches are solved anew, the same for all assemblies.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import (
    Compared,
    compare_at,
    objective,
    predict_branches,
    reweighed,
)
from updamp.comparison.fit.failing_model import inflation
from updamp.comparison.fit.fit_round import compared_at_start, one_round, prior_scatter
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter, learn
from updamp.comparison.fit.size_of_numerics import beside_noise
from updamp.comparison.fit.unsure_scatter import widening
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.continuation import BranchStoppedError

Floats = NDArray[np.float64]
Progress = Callable[[str], None]
# Share of chi2 below which a change of it is none.
_DIGITS = 1e-5
SETTLED = "settled"


@dataclass(frozen=True)
class FitOptions:
    """rounds: in which branches are solved anew, at most: several times what a fit takes that settles, since where one
        is cut short on its way hangs on round-off; largest_step: of a parameter in a round, in units of its scale
        (prior deviation, or typical size of an effect)
    tolerance: fall of chi2 to be expected of another round below which that is the last: where it leads is solved and
        has to promise no more; share: likewise, of chi2
    retraced: whether it settles, and turns back from a step, on traced branches alone, not on those that were moved:
        what no sweep saw where a branch came from has been left out of it, and may be what a sweep sees now
    circle: rounds in which it may come back to where it was, and ends; same: how near that is, in scales of the
        parameters and logarithms of the noise
    """

    rounds: int = 60
    largest_step: float = 0.5
    tolerance: float = 4.0
    share: float = _DIGITS
    retraced: bool = True
    circle: int = 6
    same: float = 1e-3


@dataclass(frozen=True, eq=False)
class Fit:
    """covariance: (p, p) of u; message: how the search ended, `SETTLED` where it did"""

    parametrisation: Parametrisation
    compared: Compared
    covariance: Floats
    message: str

    @property
    def u(self) -> Floats:
        return self.compared.u

    @property
    def deviations(self) -> Floats:
        """(p,) standard deviations of u, with the numerical error estimated from the data too"""
        return np.sqrt(np.diag(self.covariance))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of chi-square: the values less the parameters as far as these data tell them, since one
        that is known beforehand takes nothing off (D. J. C. MacKay, Neural Comput. 4 (1992) 415: well-determined
        parameters)."""
        told = 1 - (self.deviations / self.parametrisation.deviation) ** 2
        return self.compared.values - float(np.sum(told))

    @cached_property
    def covariance_told(self) -> Floats:
        """(p, p) of u, of which intervals are made: with what finer numerics change among the unknowns, each as large
        as it is unsure, and that much counting as what the model lacks too, which neighbouring points have in common.
        A thousand points would tell such a change from the parameters by details that are no surer than its shape.
        Wider where few assemblies tell by how much one differs from the next."""
        p, c = self.parametrisation, self.compared
        least = inflation(1 + self.numerics_beside_noise, 1, c.as_many)
        return covariance_of(p, c, least=least) + widening(c.assemblies, c.scatter, p.deviation)

    @property
    def numerics_beside_noise(self) -> float:
        """`size_of_numerics.beside_noise`"""
        return beside_noise(self.parametrisation, self.compared)

    @property
    def uncertainty(self) -> Floats:
        """(p,) standard deviations of u, with those that finer numerics may move it by"""
        return np.sqrt(np.diag(self.covariance_told))

    def uncertainty_of_sum(self, places: Sequence[int]) -> float:
        """Likewise of the sum of some parameters, which may be far better known than each"""
        return float(np.sqrt(max(self.covariance_told[np.ix_(places, places)].sum(), 0.0)))


def fit(
    parametrisation: Parametrisation,
    plan: Plan,
    start: Floats,
    scatter: Scatter | None = None,
    at_start: Sequence[PredictedBranch] | None = None,
    options: FitOptions | None = None,
    progress: Progress = lambda _: None,
    branches_of: Branches = in_turn,
    known: Callable[[Compared], bool] = lambda _: False,
) -> Fit:
    """Least squares of the whitened residual with the parameters' priors.

    scatter: to keep as it is; by default it is learnt from the repeats
    at_start: branches solved at `start`, where they are at hand
    known: asked of where a round leads to first order, before it is solved; where it says so that is a minimum that is
        known already, and the fit ends there, not settled
    raises: BranchStoppedError where the model has no response to compare at the start
    """
    options = options or FitOptions()
    prior = prior_scatter(parametrisation, plan)
    common = at_start if at_start is not None else predict_branches(parametrisation, start, plan, None, branches_of)
    first = compared_at_start(parametrisation, start, plan, common, scatter or prior)
    rounds = _Rounds(parametrisation, plan, scatter, prior, options, progress, branches_of, known)
    now, lately = _Reached(first, options.largest_step, options.retraced), deque[_Reached](maxlen=options.circle)
    for _ in range(options.rounds):
        lately.append(now)
        now = rounds.after(now)
        if circle := rounds.circle(lately, now):
            now = replace(min(circle, key=rounds.lacks), ended="goes round in a circle: its weights do not settle")
        if now.ended:
            break
    best = _traced(parametrisation, plan, now.best, branches_of) if now.moved else now.best
    message = now.ended or f"not settled in {options.rounds} rounds"
    return _result(parametrisation, _weighed(parametrisation, plan, best, scatter, prior), message)


@dataclass(frozen=True, eq=False)
class _Reached:
    """best: with the branches of where it stands, or near; reach: of the next step; moved: whether its branches are not
    traced; checked: the last that was traced where first order promised nothing more; only_traced: whether what is
    moved is not to be trusted any more; confirmed: whether a promise of little has led there, and it was solved
    ended: how, "" where it goes on"""

    best: Compared
    reach: float
    moved: bool
    checked: Compared | None = None
    only_traced: bool = False
    confirmed: bool = False
    ended: str = ""


@dataclass(frozen=True, eq=False)
class _Rounds:
    """What all rounds of a fit share, as `fit` has it."""

    parametrisation: Parametrisation
    plan: Plan
    scatter: Scatter | None
    prior: Scatter
    options: FitOptions
    progress: Progress
    branches_of: Branches
    known: Callable[[Compared], bool]

    def after(self, now: _Reached) -> _Reached:
        """One round further."""
        p, plan, options = self.parametrisation, self.plan, self.options
        ahead = one_round(p, plan, now.best, self.scatter, self.prior, now.reach)
        here = reweighed(p, plan, now.best, ahead.scatter)
        if self.known(ahead):
            return replace(now, best=ahead, moved=False, ended="leads to what is known")
        promised = objective(p, here) - objective(p, ahead)
        if promised < max(options.tolerance, options.share * here.weighed):
            # two standard deviations at most
            return self._at_the_end(now, ahead, here, now.confirmed or promised < _DIGITS * here.weighed)
        solved, is_traced = self._solved(now, ahead, here)
        self.progress(_fall(here, solved))
        if _rises(p, here, solved):
            shorter = now.reach / 3
            ended = "no step lowers chi-square any more" if shorter < 0.01 * options.largest_step else ""
            return replace(now, reach=shorter, ended=ended)
        longer = min(1.5 * now.reach, options.largest_step)
        return replace(now, best=solved, reach=longer, moved=options.retraced and not is_traced, confirmed=False)

    def circle(self, lately: Sequence[_Reached], now: _Reached) -> Sequence[_Reached]:
        """What was gone through since the same place, with the same weights and reach; none where it has not been
        there, or the weights have been the same since: then each step led lower. Learnt from what is left, they may
        make of each of two places the other one."""
        same = self.options.same
        last = max((i for i, one in enumerate(lately) if self._apart(one, now) < same), default=len(lately))
        since = (*tuple(lately)[last + 1 :], now) if last < len(lately) else ()
        noise = np.log([one.best.scatter.noise for one in since])
        return since if len(since) and np.ptp(noise) > same else ()

    def _apart(self, one: _Reached, other: _Reached) -> float:
        """In scales of the parameters, and logarithms of noise and reach"""
        scale = np.minimum(self.parametrisation.deviation, 1.0)
        noise, reach = np.log([one.best.scatter.noise / other.best.scatter.noise, one.reach / other.reach])
        return float(max(np.abs((one.best.u - other.best.u) / scale).max(initial=0.0), abs(noise), abs(reach)))

    def lacks(self, reached: _Reached) -> float:
        """What is left by the weights that all fits begin with"""
        return objective(self.parametrisation, reweighed(self.parametrisation, self.plan, reached.best, self.prior))

    def _at_the_end(self, now: _Reached, ahead: Compared, here: Compared, confirmed: bool) -> _Reached:
        """What is still to be gained is little, to first order. It may be more: where a gap opens that was closed at
        first order's place, or a contact begins to slip, the derivatives leap. So where it leads is solved too."""
        if confirmed:
            return self._checked(now) if now.moved else replace(now, best=ahead, ended=SETTLED)
        solved, is_traced = self._solved(now, ahead, here)
        if not _rises(self.parametrisation, here, solved):
            return replace(now, best=solved, moved=self.options.retraced and not is_traced, confirmed=True)
        return self._checked(now) if now.moved else replace(now, best=here, ended=SETTLED)

    def _checked(self, now: _Reached) -> _Reached:
        """Traced where it stands. What was moved since the last time may have seemed lower and not be: from there on
        only what is traced counts."""
        p, before = self.parametrisation, now.checked
        best, only_traced = _traced(p, self.plan, now.best, self.branches_of), now.only_traced
        if before is not None and objective(p, before) < objective(p, best):
            best, only_traced = before, True
        return replace(now, best=best, moved=False, checked=best, only_traced=only_traced)

    def _solved(self, now: _Reached, ahead: Compared, here: Compared) -> tuple[Compared, bool]:
        """Where the round leads, with branches of that place; whether these are traced."""
        p, plan = self.parametrisation, self.plan
        if not now.only_traced:
            moved = _moved(p, plan, ahead, self.branches_of, now.best)
            if not (self.options.retraced and _rises(p, here, moved)):
                return moved, False
        return _traced(p, plan, ahead, self.branches_of), True


def _moved(
    parametrisation: Parametrisation, plan: Plan, there: Compared, branches_of: Branches, near: Compared
) -> Compared:
    """The same with branches moved there from near ones."""
    branches = predict_branches(parametrisation, there.u, plan, near.branches, branches_of, inflation=there.inflation)
    return compare_at(parametrisation, there.u, plan, branches, there.scatter, there.offsets)


def _traced(parametrisation: Parametrisation, plan: Plan, there: Compared, branches_of: Branches) -> Compared:
    """The same with branches traced there, where the model has a response at the beginning of every run."""
    try:
        branches = predict_branches(parametrisation, there.u, plan, None, branches_of)
    except BranchStoppedError:
        return there
    return compare_at(parametrisation, there.u, plan, branches, there.scatter, there.offsets)


def _fall(before: Compared, after: Compared) -> str:
    errors = [float(np.sqrt(one.mean_squared_misfit)) for one in (before, after)]
    return f"error {errors[0]:.2f} to {errors[1]:.2f} times the scatter allowed"


def _rises(parametrisation: Parametrisation, before: Compared, after: Compared) -> bool:
    """Whether chi-square rises by more than its digits."""
    rise = objective(parametrisation, after) - objective(parametrisation, before)
    return rise > _DIGITS * before.weighed


def _weighed(
    parametrisation: Parametrisation, plan: Plan, found: Compared, scatter: Scatter | None, prior: Scatter
) -> Compared:
    """By the scatter that is given, or learnt, whatever it was on the way."""
    return reweighed(parametrisation, plan, found, scatter or learn(found.assemblies, prior))


def covariance_of(
    parametrisation: Parametrisation, compared: Compared, of_sensors: bool = False, least: float = 1.0
) -> Floats:
    """(p, p) of the parameters. of_sensors: as of a model that lacks nothing; least: factor on the noise
    (`Compared.equations`)"""
    _, columns = compared.equations(of_sensors, least)
    # not that of the information matrix, whose round-off may be more than what tells a parameter least
    roots = np.linalg.pinv(np.vstack([columns, np.diag(1 / parametrisation.deviation)]))
    return np.asarray(roots @ roots.T, dtype=np.float64)


def _result(parametrisation: Parametrisation, compared: Compared, message: str) -> Fit:
    return Fit(parametrisation, compared, covariance_of(parametrisation, compared), message)
