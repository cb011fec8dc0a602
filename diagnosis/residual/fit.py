"""Fit the parameters of a model to a measurement, and see what is left."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.model.predicted_branch import PredictedBranch, move_branch, trace_branch
from updamp.diagnosis.residual.matching import Matched, match
from updamp.diagnosis.residual.observations import Plan
from updamp.diagnosis.residual.scatter import (
    Assembly,
    Offsets,
    Scatter,
    assembly,
    learn,
    offsets_of,
    split,
    whitened,
)
from updamp.hbm.continuation import BranchStoppedError

Floats = NDArray[np.float64]
Progress = Callable[[str], None]


@dataclass(frozen=True)
class FitOptions:
    """rounds: of learning the scatter and fitting again; evaluations: of the model a round, at most
    tolerance: relative change of chi2 below which a round ends; match_rounds: of matching and offsets
    """

    rounds: int = 2
    evaluations: int = 12
    tolerance: float = 1e-3
    match_rounds: int = 3


@dataclass(frozen=True, eq=False)
class Compared:
    """The model at u against all runs, the scatter given.

    branches: one a condition; matched: one a run; assemblies, offsets: one a repeat; chi2: with the offsets' share
    values: number of real values compared
    """

    u: Floats
    branches: tuple[PredictedBranch, ...]
    matched: tuple[Matched, ...]
    assemblies: tuple[Assembly, ...]
    offsets: tuple[Offsets, ...]
    scatter: Scatter
    chi2: float

    @property
    def values(self) -> int:
        return sum(len(a.residual) for a in self.assemblies)

    def equations(self) -> tuple[Floats, Floats]:
        """Whitened residual (n,) and its derivative by the parameters (n, p), negative: residual = columns du."""
        pairs = [whitened(a, self.scatter) for a in self.assemblies]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([c for _, c in pairs])


@dataclass(frozen=True, eq=False)
class Fit:
    """covariance: (p, p) of u; success, message: how the search ended; prior: its share of the objective"""

    parametrisation: Parametrisation
    compared: Compared
    covariance: Floats
    prior: float
    success: bool
    message: str

    @property
    def u(self) -> Floats:
        return self.compared.u

    @property
    def objective(self) -> float:
        return self.compared.chi2 + self.prior

    @property
    def deviations(self) -> Floats:
        return np.sqrt(np.diag(self.covariance))


def predict(
    parametrisation: Parametrisation, u: Floats, plan: Plan, near: Sequence[PredictedBranch] | None = None
) -> tuple[PredictedBranch, ...]:
    """Branches of all conditions at u: moved from `near` ones where that works, else traced.

    raises: BranchStoppedError where a branch has no beginning
    """
    branches = []
    for i, condition in enumerate(plan.conditions):
        moved = move_branch(parametrisation, u, near[i]) if near is not None else None
        branches.append(moved or trace_branch(parametrisation, u, condition))
    return tuple(branches)


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
    """Match every run, with the offsets of its assembly found along the way.

    start: offsets to begin with, by repeat; spread: (p,) for the first round, later ones use the scatter
    """
    names = tuple(n.name for n in parametrisation.nuisances)
    n_effect = len(parametrisation) - len(names)
    of_scatter = np.array([*(scatter.parameters[name] for name in names), *([0.0] * n_effect)])
    all_matched, assemblies, all_offsets, chi2 = [], [], [], 0.0
    for repeat in plan.repeats:
        runs = [o for o in plan.observations if o.repeat == repeat]
        sensors = [plan.conditions[o.test].sensors for o in runs]
        offsets = (start or {}).get(repeat, Offsets(np.zeros(len(names)), {}, {}))
        first = of_scatter if spread is None else np.maximum(spread, of_scatter)
        for i in range(rounds):
            shift = np.append(offsets.parameters, np.zeros(n_effect))
            matched = [
                match(branches[o.test], o, shift, first if i == 0 else of_scatter, offsets.correction(o.run, s))
                for o, s in zip(runs, sensors, strict=True)
            ]
            equations = assembly(repeat, matched, sensors, names, offsets)
            b, part = offsets_of(equations, scatter)
            offsets = split(b, matched, sensors, len(names))
        all_matched += matched
        assemblies.append(equations)
        all_offsets.append(offsets)
        chi2 += part
    return Compared(u, tuple(branches), tuple(all_matched), tuple(assemblies), tuple(all_offsets), scatter, chi2)


def fit(
    parametrisation: Parametrisation,
    plan: Plan,
    start: Floats,
    scatter: Scatter | None = None,
    near: Sequence[PredictedBranch] | None = None,
    options: FitOptions | None = None,
    progress: Progress = lambda _: None,
) -> Fit:
    """Least squares of the whitened residual with the parameters' priors; the scatter is learnt between rounds.

    scatter: to keep as it is; by default it is learnt from the repeats
    near: branches near those at `start`
    raises: BranchStoppedError where the model has no response to compare at the start
    """
    options = options or FitOptions()
    learnt = scatter or Scatter({n.name: n.scatter for n in parametrisation.nuisances})
    search = _Search(parametrisation, plan, learnt, options, progress, near)
    u, message, success = start, "", True
    for i in range(1 if scatter is not None else options.rounds):
        found = least_squares(
            search.residuals,
            u,
            search.jacobian,
            bounds=(parametrisation.lower, parametrisation.upper),
            x_scale=_scales(parametrisation),
            ftol=options.tolerance,
            xtol=1e-6,
            gtol=1e-12,
            max_nfev=options.evaluations,
        )
        u, message, success = found.x, str(found.message), bool(found.status > 0)
        if scatter is None:
            compared = search.compared(u)
            learnt = learn(compared.assemblies, Scatter({n.name: n.scatter for n in parametrisation.nuisances}), len(u))
            search = replace_scatter(search, learnt, compared)
            progress(f"round {i + 1}: chi2 {compared.chi2:.0f} for {compared.values} values")
    compared = search.compared(u)
    _, columns = compared.equations()
    deviation = parametrisation.deviation
    prior = float(np.sum((u / deviation) ** 2))
    information = columns.T @ columns + np.diag(1 / deviation**2)
    covariance = np.asarray(np.linalg.pinv(information), dtype=np.float64)
    return Fit(parametrisation, compared, covariance, prior, success, message)


def _scales(parametrisation: Parametrisation) -> Floats:
    deviation = parametrisation.deviation
    return np.where(np.isfinite(deviation), deviation, 1.0)


class _Search:
    """What least squares asks for, with the last evaluations kept: value and derivative come from the same one."""

    def __init__(
        self,
        parametrisation: Parametrisation,
        plan: Plan,
        scatter: Scatter,
        options: FitOptions,
        progress: Progress,
        near: Sequence[PredictedBranch] | None,
        spread: Floats | None = None,
    ) -> None:
        self.parametrisation, self.plan, self.scatter, self.options = parametrisation, plan, scatter, options
        self.progress, self.near = progress, near
        deviation = parametrisation.deviation
        self.spread = np.where(np.isfinite(deviation), deviation, 0.0) if spread is None else spread
        self.kept: dict[bytes, Compared] = {}
        self.offsets: Mapping[int, Offsets] = {}
        self.fewest = np.inf

    def compared(self, u: Floats) -> Compared:
        key = u.tobytes()
        if key not in self.kept:
            branches = predict(self.parametrisation, u, self.plan, self.near)
            self.kept[key] = compare_at(
                self.parametrisation,
                u,
                self.plan,
                branches,
                self.scatter,
                self.offsets,
                self.spread,
                self.options.match_rounds,
            )
            if self.kept[key].chi2 < self.fewest:
                self.fewest = self.kept[key].chi2
                self.near = branches
            self.progress(f"chi2 {self.kept[key].chi2:.0f}")
        return self.kept[key]

    def residuals(self, u: Floats) -> Floats:
        try:
            r, _ = self.compared(u).equations()
        except BranchStoppedError:
            # no response there: as bad as anything, so that the search turns back
            return np.full(self._length(), 1e3)
        return np.concatenate([r, u / self.parametrisation.deviation])

    def jacobian(self, u: Floats) -> Floats:
        _, columns = self.compared(u).equations()
        return np.vstack([-columns, np.diag(1 / self.parametrisation.deviation)])

    def _length(self) -> int:
        return sum(o.observed.shape[0] * (o.observed.shape[1] - 1) for o in self.plan.observations) + len(
            self.parametrisation
        )


def replace_scatter(search: _Search, scatter: Scatter, compared: Compared) -> _Search:
    """The same search with another scatter: its evaluations are weighed anew, not solved anew."""
    names = tuple(n.name for n in search.parametrisation.nuisances)
    spread = np.array([scatter.parameters[n] for n in names])
    spread = np.append(spread, np.zeros(len(search.parametrisation) - len(names)))
    new = _Search(
        search.parametrisation, search.plan, scatter, search.options, search.progress, compared.branches, spread
    )
    new.offsets = dict(zip(search.plan.repeats, compared.offsets, strict=True))
    again = compare_at(search.parametrisation, compared.u, search.plan, compared.branches, scatter, new.offsets, spread)
    new.kept[compared.u.tobytes()] = again
    new.fewest = again.chi2
    return new
