"""Fit the parameters of a model to a measurement, and see what is left.

Two loops (M. J. Lindstrom and D. M. Bates, Biometrics 46 (1990) 673): inside, the branches are taken as linear in the
parameters about where they were solved, while parameters, the offsets of each assembly and the scatter are fitted;
outside, the branches are solved anew, the same for all assemblies.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from updamp.comparison.fit.matching import Matched, match
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.scatter import (
    Assembly,
    Offsets,
    Scatter,
    assembly,
    learn,
    offsets_of,
    split,
    whitened,
    within_reach,
)
from updamp.comparison.prediction.branch_tasks import Branches, BranchTask, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.continuation import ContinuationOptions

Floats = NDArray[np.float64]
Progress = Callable[[str], None]
# Share by which chi2 may rise in a step: it is rough, since contacts begin to slip one after the other.
_ROUGH = 0.005
# Share of chi2 below which a change of it is none.
_DIGITS = 1e-5
# Change of a nuisance parameter up to which branches are nearly linear in it, however well it is known beforehand.
_LINEAR = 0.2
# Scatter of the parameters of a single assembly, as a share of what they are expected to scatter by.
_ALONE = 1e-3
# chi2 a value from where on the model fails grossly: by ten times the scatter on average.
GROSS = 100.0
# chi2 a value up to which a misfit is weighed as it is; beyond it a model fails badly.
TOLERATED = 3.0
# Points along a curve that count as one for what a model lacks: its misfit there is the same.
AS_MANY = 10.0


@dataclass(frozen=True)
class FitOptions:
    """rounds: in which branches are solved anew, at most; largest_step: of a parameter in a round, in units of its
        scale (prior deviation, or typical size of an effect)
    tolerance: fall of chi2 to be expected of another round below which there is none
    """

    rounds: int = 12
    largest_step: float = 0.5
    tolerance: float = 4.0


@dataclass(frozen=True, eq=False)
class Compared:
    """The model at u against all runs, the scatter given.

    branches: one a condition; matched: one a run; assemblies: one a repeat; offsets: by repeat
    chi2: with the offsets' share
    values: number of real values compared
    """

    u: Floats
    branches: tuple[PredictedBranch, ...]
    matched: tuple[Matched, ...]
    assemblies: tuple[Assembly, ...]
    offsets: Mapping[int, Offsets]
    scatter: Scatter
    chi2: float

    @property
    def values(self) -> int:
        return sum(len(a.residual) for a in self.assemblies)

    @property
    def excess(self) -> float:
        """chi2 a value"""
        return self.chi2 / self.values

    def equations(self) -> tuple[Floats, Floats]:
        """Whitened residual (n,) and its derivative by the parameters (n, p), negative: residual = columns du."""
        pairs = [whitened(a, self.scatter) for a in self.assemblies]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([c for _, c in pairs])


@dataclass(frozen=True, eq=False)
class Fit:
    """covariance: (p, p) of u; success, message: how the search ended"""

    parametrisation: Parametrisation
    compared: Compared
    covariance: Floats
    success: bool
    message: str

    @property
    def u(self) -> Floats:
        return self.compared.u

    @property
    def deviations(self) -> Floats:
        """(p,) as the data tell u, the numerical error told by them too"""
        return np.sqrt(np.diag(self.covariance))

    @property
    def given_numerics(self) -> Floats:
        """(p,) deviations with the numerical error taken as it was found, 0 for that error itself"""
        n, found = self.parametrisation.n_of_model, np.zeros(len(self.u))
        own, crossed, of_numerics = self.covariance[:n, :n], self.covariance[:n, n:], self.covariance[n:, n:]
        left = own - crossed @ np.linalg.pinv(of_numerics) @ crossed.T
        found[:n] = np.sqrt(np.maximum(np.diag(left), 0.0))
        return found

    @property
    def uncertainty(self) -> Floats:
        """(p,) deviations of u with those that finer numerics may move it by, counted once: what intervals are made
        of"""
        return np.hypot(self.given_numerics, self.parametrisation.numerics.uncertainty(len(self.u)))


def predict(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    near: Sequence[PredictedBranch] | None = None,
    branches_of: Branches = in_turn,
    options: ContinuationOptions | None = None,
) -> tuple[PredictedBranch, ...]:
    """Branches of all conditions at u: moved from `near` ones where that works, else traced.

    options: of the continuation, that `near` ones have been traced with

    raises: BranchStoppedError where a branch has no beginning
    """
    starts = near if near is not None else [None] * len(plan.conditions)
    return branches_of(
        [BranchTask(parametrisation, u, c, start, options) for c, start in zip(plan.conditions, starts, strict=True)]
    )


def compare_at(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    scatter: Scatter,
    start: Mapping[int, Offsets] | None = None,
    spread: Floats | None = None,
    rounds: int = 3,
) -> Compared:
    """Match every run at u, to first order from the branches, with the offsets of its assembly found along the way.

    start: offsets to begin with, by repeat; spread: (p,) for the first round, later ones use the scatter
    """
    n = len(parametrisation.nuisances)
    of_scatter = _padded(np.array([scatter.parameters[x.name] for x in parametrisation.nuisances]), len(u))
    parts = []
    for repeat in plan.repeats:
        runs = [o for o in plan.observations if o.repeat == repeat]
        offsets = (start or {}).get(repeat, Offsets(np.zeros(n), {}, {}))
        misfit = 1.0
        first = of_scatter if spread is None else np.maximum(spread, of_scatter)
        for i in range(rounds):
            width = first if i == 0 else of_scatter
            matched, equations = _assembled(parametrisation, u, plan, runs, branches, offsets, width, misfit)
            b, chi2 = offsets_of(equations, scatter)
            if fails_grossly(parametrisation, chi2, len(equations.residual)):
                misfit = scatter.noise * float(np.sqrt(chi2 / len(equations.residual)))
                b = within_reach(b, equations, scatter)
            offsets = split(b, matched, [plan.conditions[o.test].sensors for o in runs], n)
        parts.append((matched, equations, offsets, chi2))
    return Compared(
        u,
        tuple(branches),
        tuple(m for matched, *_ in parts for m in matched),
        tuple(part[1] for part in parts),
        dict(zip(plan.repeats, (part[2] for part in parts), strict=True)),
        scatter,
        sum(part[3] for part in parts),
    )


def fails_grossly(parametrisation: Parametrisation, chi2: float, values: int) -> bool:
    """Whether a model without contacts is off by ten times the scatter on average. One with contacts has other
    damping than the material's to calibrate, and is only that far off before it is calibrated."""
    return parametrisation.base.contacts is None and chi2 > GROSS * values


def _assembled(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    runs: Sequence[Observations],
    branches: Sequence[PredictedBranch],
    offsets: Offsets,
    spread: Floats,
    misfit: float,
) -> tuple[list[Matched], Assembly]:
    """One repeat with its offsets given."""
    sensors = [plan.conditions[o.test].sensors for o in runs]
    there = u + _padded(offsets.parameters, len(u))
    matched = [
        match(branches[o.test], o, there, spread, offsets.correction(o.run, s), misfit)
        for o, s in zip(runs, sensors, strict=True)
    ]
    names = tuple(x.name for x in parametrisation.nuisances)
    return matched, assembly(runs[0].repeat, matched, sensors, names, offsets)


def _padded(values: Floats, length: int) -> Floats:
    return np.append(values, np.zeros(length - len(values)))


def fit(
    parametrisation: Parametrisation,
    plan: Plan,
    start: Floats,
    scatter: Scatter | None = None,
    at_start: Sequence[PredictedBranch] | None = None,
    options: FitOptions | None = None,
    progress: Progress = lambda _: None,
    branches_of: Branches = in_turn,
) -> Fit:
    """Least squares of the whitened residual with the parameters' priors.

    scatter: to keep as it is; by default it is learnt from the repeats
    at_start: branches solved at `start`, where they are at hand
    raises: BranchStoppedError where the model has no response to compare at the start
    """
    options = options or FitOptions()
    # the only assembly is what the parameters are fitted to: its offsets from others cannot be told from them
    share = 1.0 if len(plan.repeats) > 1 else _ALONE
    prior = Scatter({n.name: share * n.scatter for n in parametrisation.nuisances})
    common = tuple(at_start) if at_start is not None else predict(parametrisation, start, plan, None, branches_of)
    spread = np.where(np.isfinite(parametrisation.deviation), parametrisation.deviation, 0.0)
    best = compare_at(parametrisation, start, plan, common, scatter or prior, None, spread)
    reach, message = options.largest_step, f"not settled in {options.rounds} rounds"
    for _ in range(options.rounds):
        ahead = _round(parametrisation, plan, best, scatter, prior, reach)
        here = reweighed(parametrisation, plan, best, ahead.scatter)
        now = objective(parametrisation, here)
        if now - objective(parametrisation, ahead) < max(options.tolerance, _DIGITS * now):
            # what is still to be gained is, to first order: two standard deviations at most, no need for solving anew
            return _result(parametrisation, _weighed(parametrisation, plan, ahead, scatter, prior), True, "settled")
        common = predict(parametrisation, ahead.u, plan, best.branches, branches_of)
        solved = compare_at(parametrisation, ahead.u, plan, common, ahead.scatter, ahead.offsets)
        progress(f"error {np.sqrt(here.excess):.2f} to {np.sqrt(solved.excess):.2f} times the scatter allowed")
        gross = fails_grossly(parametrisation, here.chi2, here.values)
        if objective(parametrisation, solved) - now > (_DIGITS if gross else _ROUGH) * here.chi2:
            reach /= 3
            if reach < 0.01 * options.largest_step:
                message = "no step lowers chi2 any more"
                break
            continue
        best, reach = solved, min(1.5 * reach, options.largest_step)
    return _result(parametrisation, _weighed(parametrisation, plan, best, scatter, prior), False, message)


def fit_linear(
    parametrisation: Parametrisation, plan: Plan, compared: Compared, scatter: Scatter, reach: float
) -> Compared:
    """Where a fit with a given scatter would go in one round: the branches linear in the parameters, which may change
    by `reach` of their scale."""
    prior = Scatter({n.name: n.scatter for n in parametrisation.nuisances})
    ahead = _round(parametrisation, plan, compared, scatter, prior, reach)
    return reweighed(parametrisation, plan, ahead, scatter)


def _round(
    parametrisation: Parametrisation, plan: Plan, best: Compared, scatter: Scatter | None, prior: Scatter, reach: float
) -> Compared:
    """One round, weighed by noise as loose as the model fails."""
    given = scatter or replace(best.scatter, noise=prior.noise)
    loose = looseness(parametrisation, reweighed(parametrisation, plan, best, given))
    about = best if loose == 1 else reweighed(parametrisation, plan, best, loosened(given, loose))
    return _fit_linear(parametrisation, plan, about, scatter, loosened(prior, loose), reach)


def looseness(parametrisation: Parametrisation, compared: Compared) -> float:
    """Factor on the noise where a model fails.

    What is missing in a model is wrong all along a curve in the same way. Weighed as if every point told it anew, a
    large misfit would outweigh whatever is known of the parameters, and they would go wherever they lessen it a little.
    """
    if parametrisation.base.contacts is None:
        return 1.0
    return max(1.0, min(compared.excess / TOLERATED, float(np.sqrt(AS_MANY * compared.excess))))


def loosened(scatter: Scatter, factor: float) -> Scatter:
    """With so many times the noise."""
    return replace(scatter, noise=factor * scatter.noise)


def _weighed(
    parametrisation: Parametrisation, plan: Plan, found: Compared, scatter: Scatter | None, prior: Scatter
) -> Compared:
    """By the scatter that is given, or learnt, whatever it was loosened to on the way."""
    return reweighed(parametrisation, plan, found, scatter or learn(found.assemblies, prior))


def reweighed(parametrisation: Parametrisation, plan: Plan, compared: Compared, scatter: Scatter) -> Compared:
    """The same comparison weighed with another scatter."""
    return compare_at(parametrisation, compared.u, plan, compared.branches, scatter, compared.offsets)


def _fit_linear(
    parametrisation: Parametrisation,
    plan: Plan,
    about: Compared,
    scatter: Scatter | None,
    prior: Scatter,
    reach: float,
) -> Compared:
    """Parameters, offsets and scatter with the branches linear about where they were solved."""
    deviation = parametrisation.deviation
    # effects, of which nothing is known beforehand, may grow by as much as they are
    limits = reach * np.where(np.isfinite(deviation), np.maximum(deviation, _LINEAR), np.maximum(1.0, np.abs(about.u)))
    limits[parametrisation.n_of_model :] = 2 * parametrisation.upper[parametrisation.n_of_model :]  # exactly linear
    lower = np.maximum(parametrisation.lower, about.u - limits)
    upper = np.minimum(parametrisation.upper, about.u + limits)
    now = about
    for _ in range(3):
        equations = _Equations(parametrisation, plan, now)
        found = least_squares(
            equations.residual,
            np.clip(now.u, lower + 1e-9, upper - 1e-9),
            equations.jacobian,
            bounds=(lower, upper),
            x_scale=limits / reach,
            ftol=1e-4,
            max_nfev=8,
        )
        before, now = now, equations.at(found.x)
        if scatter is None:
            now = replace(now, scatter=learn(now.assemblies, prior))
        if np.max(np.abs(now.u - before.u) / limits) < 0.01:
            break
    return now


class _Equations:
    """What least squares asks for, with the branches linear; each evaluation gives the value and the derivative."""

    def __init__(self, parametrisation: Parametrisation, plan: Plan, about: Compared) -> None:
        self._parametrisation, self._plan, self._about = parametrisation, plan, about
        self._kept: dict[bytes, Compared] = {}

    def at(self, u: Floats) -> Compared:
        if u.tobytes() not in self._kept:
            about = self._about
            self._kept[u.tobytes()] = compare_at(
                self._parametrisation, u, self._plan, about.branches, about.scatter, about.offsets, None, 2
            )
        return self._kept[u.tobytes()]

    def residual(self, u: Floats) -> Floats:
        return np.concatenate([self.at(u).equations()[0], u / self._parametrisation.deviation])

    def jacobian(self, u: Floats) -> Floats:
        return np.vstack([-self.at(u).equations()[1], np.diag(1 / self._parametrisation.deviation)])


def misfit(parametrisation: Parametrisation, compared: Compared) -> float:
    """Minus twice the logarithm of the posterior probability, the best noise of the sensors' and more taken: what
    models that fail are compared by. For one that does not it is chi2 with the priors' share."""
    excess, n = compared.excess, compared.values
    of_data = n * excess if excess < 1 else n * (1 + float(np.log(excess)))
    return of_data + float(np.sum((compared.u / parametrisation.deviation) ** 2))


def objective(parametrisation: Parametrisation, compared: Compared) -> float:
    """What a fit lowers: chi2 and the priors' share."""
    return compared.chi2 + float(np.sum((compared.u / parametrisation.deviation) ** 2))


def _covariance(parametrisation: Parametrisation, compared: Compared) -> Floats:
    _, columns = compared.equations()
    # where the model fails grossly, with the noise that its misfit asks for (R. T. Birge, Phys. Rev. 40 (1932) 207)
    if fails_grossly(parametrisation, compared.chi2, compared.values):
        columns = columns / np.sqrt(compared.excess)
    information = columns.T @ columns + np.diag(1 / parametrisation.deviation**2)
    return np.asarray(np.linalg.pinv(information), dtype=np.float64)


def _result(parametrisation: Parametrisation, compared: Compared, success: bool, message: str) -> Fit:
    return Fit(parametrisation, compared, _covariance(parametrisation, compared), success, message)
