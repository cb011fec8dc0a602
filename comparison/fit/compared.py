"""The model at given parameters against all runs: chi-square, what a fit lowers, and the misfit that models are
compared by."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.failing_model import inflation, unlikelihood
from updamp.comparison.fit.matching import Matched, match
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.offsets import Offsets, assembly, split
from updamp.comparison.fit.scatter import Assembly, Scatter, offsets_of, parts_of_chi2, whitened
from updamp.comparison.prediction.branch_tasks import Branches, BranchTask, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition, same_sweeps
from updamp.hbm.continuation.continuation import ContinuationOptions

Floats = NDArray[np.float64]

# Fall of chi-square, still to be expected of other offsets, below which they are found: three hundredths of what they
# are unsure by.
_FOUND = 1e-3


@dataclass(frozen=True, eq=False)
class Compared:
    """The model at u against all runs, the scatter given.

    branches: one a condition; matched: one a run; assemblies: one a repeat; offsets: by repeat
    left: of each assembly the sum of squares in deviations of the sensors, without the offsets' share; of_offsets: that
    values: number of real values compared; as_many: points that count as one for what the model lacks
    """

    u: Floats
    branches: tuple[PredictedBranch, ...]
    matched: tuple[Matched, ...]
    assemblies: tuple[Assembly, ...]
    offsets: Mapping[int, Offsets]
    scatter: Scatter
    left: tuple[float, ...]
    of_offsets: float
    as_many: float

    @property
    def chi2(self) -> float:
        """With the offsets' share, the noise as the scatter has it."""
        return sum(self.left) + self.of_offsets

    def with_scatter(self, scatter: Scatter) -> "Compared":
        """Weighed by another one, the offsets as they are."""
        parts = [parts_of_chi2(a, scatter) for a in self.assemblies]
        return replace(
            self, scatter=scatter, left=tuple(left for left, _ in parts), of_offsets=sum(o for _, o in parts)
        )

    @property
    def values(self) -> int:
        return sum(len(a.residual) for a in self.assemblies)

    @property
    def mean_squared_misfit(self) -> float:
        """Chi-square over the number of measured values, 1 where the scatter is all there is."""
        return self.chi2 / self.values

    @property
    def unlikelihood(self) -> float:
        """Minus twice the logarithm of the probability of data and offsets (`failing_model.py`)."""
        return self.of_offsets + sum(unlikelihood(*each, self.as_many) for each in self._left)

    @property
    def inflation(self) -> float:
        """Factor on the noise for what the model lacks, over all assemblies (RMS)."""
        squares = [len(a.residual) * f**2 for a, f in zip(self.assemblies, self._factors, strict=True)]
        return float(np.sqrt(sum(squares) / self.values))

    @property
    def _left(self) -> list[tuple[float, int]]:
        return [(left, len(a.residual)) for left, a in zip(self.left, self.assemblies, strict=True)]

    @property
    def _factors(self) -> list[float]:
        return [inflation(*each, self.as_many) for each in self._left]

    @property
    def weighed(self) -> float:
        """Chi-square as it counts beside priors."""
        return self.chi2 / self.inflation**2

    def equations(self, of_sensors: bool = False, least: float = 1.0) -> tuple[Floats, Floats]:
        """Whitened residual (n,) and its derivative by the parameters (n, p), negative: residual = columns du.

        of_sensors: by the sensors' noise alone, however far the model fails; else what it lacks counts as noise
        least: factor on the noise, where what the model lacks does not make it larger
        """
        factors = [least if of_sensors else max(f, least) for f in self._factors]
        pairs = [whitened(a, self.scatter.inflated(f)) for a, f in zip(self.assemblies, factors, strict=True)]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([c for _, c in pairs])


def predict_branches(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    near: Sequence[PredictedBranch | None] | None = None,
    branches_of: Branches = in_turn,
    options: ContinuationOptions | None = None,
    inflation: float = 1.0,
) -> tuple[PredictedBranch, ...]:
    """Branches of all conditions at u: moved from `near` ones where there are such and that works, else traced.

    options: of the continuation, that `near` ones have been traced with
    inflation: factor on the noise that the model will be weighed with, to which it need not be interpolated any better

    raises: BranchStoppedError where a branch has no beginning
    """
    starts = near if near is not None else [None] * len(plan.conditions)
    conditions = [c.less_sure(inflation) for c in plan.conditions]
    together = same_sweeps(conditions)
    tasks = [
        BranchTask(parametrisation, u, conditions[first], starts[first], options, tuple(conditions[i] for i in others))
        for first, *others in together
    ]
    found = dict(zip(chain.from_iterable(together), branches_of(tasks), strict=True))
    return tuple(found[i] for i in range(len(conditions)))


def compare_at(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    scatter: Scatter,
    start: Mapping[int, Offsets] | None = None,
    spread: Floats | None = None,
    rounds: int = 4,
) -> Compared:
    """Match every run at u, to first order from the branches, with the offsets of its assembly found along the way.

    start: offsets to begin with, by repeat; spread: (p,) for the first round, later ones use the scatter
    rounds: in which offsets are tried, the first ones among them
    """
    of_scatter = padded(np.array([scatter.parameters[x.name] for x in parametrisation.nuisances]), len(u))
    first = of_scatter if spread is None else np.maximum(spread, of_scatter)
    given = _Given(parametrisation, u, plan, branches, scatter)
    widths = (first, *[of_scatter] * (rounds - 1))
    parts = [given.of_repeat(repeat, (start or {}).get(repeat), widths) for repeat in plan.repeats]
    return Compared(
        u,
        tuple(branches),
        tuple(m for part in parts for m in part.matched),
        tuple(part.assembly for part in parts),
        dict(zip(plan.repeats, (part.offsets for part in parts), strict=True)),
        scatter,
        tuple(part.left for part in parts),
        sum(part.of_offsets for part in parts),
        plan.as_many,
    )


@dataclass(frozen=True, eq=False)
class _OfRepeat:
    matched: tuple[Matched, ...]
    assembly: Assembly
    offsets: Offsets
    left: float
    of_offsets: float
    as_many: float

    @property
    def unlikelihood(self) -> float:
        return unlikelihood(self.left, len(self.assembly.residual), self.as_many) + self.of_offsets

    def ahead(self, scatter: Scatter) -> "_Ahead":
        """The offsets that are likeliest to first order, with the noise that the misfit asks for."""
        factor = inflation(self.left, len(self.assembly.residual), self.as_many)
        return self.ahead_by(scatter.inflated(factor))

    def ahead_by(self, scatter: Scatter) -> "_Ahead":
        """Likewise, the noise as the scatter has it."""
        offsets, chi2 = offsets_of(self.assembly, scatter)
        return _Ahead(offsets, sum(parts_of_chi2(self.assembly, scatter)) - chi2)


@dataclass(frozen=True, eq=False)
class _Ahead:
    """Where offsets lead to first order. offsets: (q,); fall: of chi-square, to be expected"""

    offsets: Floats
    fall: float


@dataclass(frozen=True, eq=False)
class _Given:
    """What is compared, but for the offsets."""

    parametrisation: Parametrisation
    u: Floats
    plan: Plan
    branches: Sequence[PredictedBranch]
    scatter: Scatter

    def of_repeat(self, repeat: int, start: Offsets | None, widths: Sequence[Floats]) -> _OfRepeat:
        """With its best offsets; start: to begin with; widths: as `_with_best_offsets`"""
        runs = [o for o in self.plan.observations if o.repeat == repeat]
        n = len(self.parametrisation.nuisances)
        known = start or Offsets(np.zeros(n), {}, {}, {}, {})

        def assembled(b: Floats | None, width: Floats) -> _OfRepeat:
            return self._assembled(runs, known if b is None else split(b, runs, self._conditions(runs)), width)

        return _with_best_offsets(assembled, self.scatter, widths)

    def _assembled(self, runs: Sequence[Observations], offsets: Offsets, width: Floats) -> _OfRepeat:
        conditions = self._conditions(runs)
        there = self.u + padded(offsets.parameters, len(self.u))
        matched = [
            match(self.branches[o.test], o, there, width, offsets.correction(o, condition))
            for o, condition in zip(runs, conditions, strict=True)
        ]
        names = tuple(x.name for x in self.parametrisation.nuisances)
        equations = assembly(runs[0].repeat, matched, conditions, names, offsets)
        parts = parts_of_chi2(equations, self.scatter)
        return _OfRepeat(tuple(matched), equations, offsets, *parts, self.plan.as_many)

    def _conditions(self, runs: Sequence[Observations]) -> list[RunCondition]:
        return [self.plan.conditions[o.test] for o in runs]


def _with_best_offsets(
    assembled: Callable[[Floats | None, Floats], _OfRepeat], scatter: Scatter, widths: Sequence[Floats]
) -> _OfRepeat:
    """Gauss-Newton in the offsets until they are found, at first as if the model lacked nothing: where that explains a
    misfit the model does not fail, and with the noise inflated by the misfit first order would not lead there. Near a
    jump a shift of the frequency may put points on the other side of it, far off what first order says: a step that
    does not make them likelier is halved.

    assembled: from offsets, None for the first ones, and the width that points are matched with; widths: of each round
    """
    best, matched_by = assembled(None, widths[0]), widths[0]
    ahead = best.ahead_by(scatter)
    if ahead.fall < _FOUND:
        ahead = best.ahead(scatter)
    for tries, width in enumerate(widths[1:]):
        if ahead.fall < _FOUND and np.array_equal(matched_by, width):
            break
        tried = assembled(ahead.offsets, width)
        if tried.unlikelihood <= best.unlikelihood:
            best, matched_by = tried, width
            ahead = best.ahead(scatter)
        elif tries == 0:
            ahead = best.ahead(scatter)
        else:
            ahead = replace(ahead, offsets=(ahead.offsets + best.assembly.offsets) / 2)
    return best


def padded(values: Floats, length: int) -> Floats:
    return np.append(values, np.zeros(length - len(values)))


def reweighed(parametrisation: Parametrisation, plan: Plan, compared: Compared, scatter: Scatter) -> Compared:
    """The same comparison weighed with another scatter."""
    return compare_at(parametrisation, compared.u, plan, compared.branches, scatter, compared.offsets)


def misfit(parametrisation: Parametrisation, compared: Compared) -> float:
    """Minus twice the logarithm of the posterior probability, the best noise of the sensors' and more taken: what
    models that fail are compared by. For one that does not it is chi2 with the priors' share."""
    mean, n = compared.mean_squared_misfit, compared.values
    of_data = n * mean if mean < 1 else n * (1 + float(np.log(mean)))
    return of_data + float(np.sum((compared.u / parametrisation.deviation) ** 2))


def objective(parametrisation: Parametrisation, compared: Compared) -> float:
    """What a fit lowers: chi2 and the priors' share where the model does not fail (`failing_model.py`)."""
    return compared.unlikelihood + float(np.sum((compared.u / parametrisation.deviation) ** 2))
