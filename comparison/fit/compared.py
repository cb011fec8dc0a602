"""The model at given parameters against all runs: chi-square, the misfit that models are compared by, and how much the
noise is inflated where a model fails."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.matching import Matched, match
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.scatter import (
    Assembly,
    Offsets,
    Scatter,
    assembly,
    chi2_at,
    offsets_of,
    split,
    whitened,
)
from updamp.comparison.prediction.branch_tasks import Branches, BranchTask, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.continuation import ContinuationOptions

Floats = NDArray[np.float64]
Sensors = Sequence[Sequence[tuple[str, int]]]
# Mean squared misfit from where on the model fails grossly: by ten times the scatter on average.
GROSS = 100.0
# Mean squared misfit up to which it is weighed as it is; beyond it a model fails badly.
TOLERATED = 3.0
# Points along a curve that count as one for what a model lacks: its misfit there is the same.
AS_MANY = 10.0


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
    def mean_squared_misfit(self) -> float:
        """Chi-square over the number of measured values, 1 where the scatter is all there is."""
        return self.chi2 / self.values

    def equations(self) -> tuple[Floats, Floats]:
        """Whitened residual (n,) and its derivative by the parameters (n, p), negative: residual = columns du."""
        pairs = [whitened(a, self.scatter) for a in self.assemblies]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([c for _, c in pairs])


def predict_branches(
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
    rounds: int = 4,
) -> Compared:
    """Match every run at u, to first order from the branches, with the offsets of its assembly found along the way.

    start: offsets to begin with, by repeat; spread: (p,) for the first round, later ones use the scatter
    rounds: in which offsets are tried, the first ones among them
    """
    n = len(parametrisation.nuisances)
    of_scatter = _padded(np.array([scatter.parameters[x.name] for x in parametrisation.nuisances]), len(u))
    first = of_scatter if spread is None else np.maximum(spread, of_scatter)
    parts = []
    for repeat in plan.repeats:
        runs = [o for o in plan.observations if o.repeat == repeat]
        sensors = [plan.conditions[o.test].sensors for o in runs]

        def assembled(
            b: Floats | None, width: Floats, runs: Sequence[Observations] = runs, sensors: Sensors = sensors
        ) -> _OfRepeat:
            known = (start or {}).get(runs[0].repeat, Offsets(np.zeros(n), {}, {}))
            offsets = known if b is None else split(b, runs, sensors, n)
            matched, equations = _assembled(parametrisation, u, plan, runs, branches, offsets, width)
            return _OfRepeat(tuple(matched), equations, offsets, chi2_at(equations, scatter))

        parts.append(_with_best_offsets(assembled, scatter, (first, *[of_scatter] * (rounds - 1))))
    return Compared(
        u,
        tuple(branches),
        tuple(m for part in parts for m in part.matched),
        tuple(part.assembly for part in parts),
        dict(zip(plan.repeats, (part.offsets for part in parts), strict=True)),
        scatter,
        sum(part.chi2 for part in parts),
    )


@dataclass(frozen=True, eq=False)
class _OfRepeat:
    matched: tuple[Matched, ...]
    assembly: Assembly
    offsets: Offsets
    chi2: float


def _with_best_offsets(
    assembled: Callable[[Floats | None, Floats], _OfRepeat], scatter: Scatter, widths: Sequence[Floats]
) -> _OfRepeat:
    """Gauss-Newton in the offsets. Near a jump a shift of the frequency may put points on the other side of it, far off
    what first order says: a step that does not lower chi2 is halved.

    assembled: from offsets, None for the first ones, and the width that points are matched with; widths: of each round
    """
    best = assembled(None, widths[0])
    ahead, _ = offsets_of(best.assembly, scatter)
    for width in widths[1:]:
        tried = assembled(ahead, width)
        if tried.chi2 <= best.chi2:
            best = tried
            ahead, _ = offsets_of(best.assembly, scatter)
        else:
            ahead = (ahead + best.assembly.offsets) / 2
    return best


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
) -> tuple[list[Matched], Assembly]:
    """One repeat with its offsets given."""
    sensors = [plan.conditions[o.test].sensors for o in runs]
    there = u + _padded(offsets.parameters, len(u))
    matched = [
        match(branches[o.test], o, there, spread, offsets.correction(o.run, s))
        for o, s in zip(runs, sensors, strict=True)
    ]
    names = tuple(x.name for x in parametrisation.nuisances)
    return matched, assembly(runs[0].repeat, matched, sensors, names, offsets)


def _padded(values: Floats, length: int) -> Floats:
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
    """What a fit lowers: chi2 and the priors' share."""
    return compared.chi2 + float(np.sum((compared.u / parametrisation.deviation) ** 2))


def noise_inflation(parametrisation: Parametrisation, compared: Compared) -> float:
    """Factor on the noise where a model fails.

    What is missing in a model is wrong all along a curve in the same way. Weighed as if every point were independent, a
    large misfit would outweigh whatever is known of the parameters, and they would go wherever they lessen it a little.
    """
    if parametrisation.base.contacts is None:
        return 1.0
    return max(
        1.0, min(compared.mean_squared_misfit / TOLERATED, float(np.sqrt(AS_MANY * compared.mean_squared_misfit)))
    )


def with_inflated_noise(scatter: Scatter, factor: float) -> Scatter:
    """With so many times the noise."""
    return replace(scatter, noise=factor * scatter.noise)
