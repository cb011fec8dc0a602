"""Where a model fails badly, what each effect could do about it: to first order about a model that has it already.

About a calibrated model that lacks something large, first order tells little: calibration has led it astray, and
effects of the contacts are not linear that far (an uneven pressure acts with its square at first). So each effect is
put into the model as given at its typical size, with both signs where it has two, and the rest is linear from there;
once more from where that leads if it leads as far as it may. An effect without a derivative at its null value is not
linear in its size either: it is put in whole too, where it may be (`Effect.sizes`). What is solved is no promise: a
size that leaves less than the calibrated model does as it is, is a start for a fit as well.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import compare_at, misfit, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.fit_round import fit_linear
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.branch_tasks import BranchesBy
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import without_branches
from updamp.diagnosis.candidate_models.refit import COARSE, REACH, coarse_enough
from updamp.effects.effect import Effect
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.parallel.workers import LongestFirst, Workers, here

Floats = NDArray[np.float64]
# Distance of the points that a probe is moved from: half of the longest step of a branch traced for a first guess.
# Where contacts begin to slip these lie closer by far, and each takes as long as the law of an effect does.
_APART = COARSE.largest_step / 2


@dataclass(frozen=True, eq=False)
class Probe:
    """start: (p,) of the effect's parameters in typical sizes, where the misfit is least to first order
    misfit: there (`fit.misfit`), on the runs that were looked at
    size: (p,) likewise, that first order is about; solved: misfit there
    better: the size that leaves least of those solved, where that is less than the calibrated model leaves"""

    effect: Effect
    start: Floats
    misfit: float
    size: Floats
    solved: float
    better: tuple[Floats, ...] = ()

    @property
    def starts(self) -> tuple[Floats, ...]:
        """Of a fit, in this order"""
        return self.start, *self.better


def probes(
    start: Baseline,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
    workers: Workers = here,
) -> tuple[Probe, ...]:
    """The best one of each effect, the least misfit first; effects with which the model has no response are left out.

    Looks at the highest level of each mode alone, where most is seen of what depends on the amplitude.
    """
    plan = start.train_plan.only(highest_levels(start.train_plan))
    (p, at), inflation = start.as_given, start.fitted.compared.inflation
    near = predict_branches(p, at, plan, None, BranchesBy(workers), coarse_enough(start.fitted), inflation)
    shared = _About(
        without_branches(start.fitted), plan, p, at, [branch.thinned(_APART) for branch in near], _calibrated(start)
    )
    # an effect without derivative is of a law or of harmonics that take longer
    longest_first = LongestFirst(workers, lambda effect: effect.finite_step)
    found = longest_first(_best_of, shared, effects, lambda i, _: progress(f"{effects[i].name} at its typical size"))
    return tuple(sorted((probe for probe in found if probe is not None), key=_misfit))


def _calibrated(start: Baseline) -> float:
    """What the calibrated model leaves on the runs that are looked at (`fit.misfit`)"""
    fitted, wanted = start.fitted, highest_levels(start.train_plan)
    branches = [fitted.compared.branches[i] for i in wanted]
    plan, offsets = start.train_plan.only(wanted), fitted.compared.offsets
    compared = compare_at(fitted.parametrisation, fitted.u, plan, branches, fitted.compared.scatter, offsets)
    return misfit(fitted.parametrisation, compared)


@dataclass(frozen=True, eq=False)
class _About:
    """base: without its branches; given, at: the model as given and (p,) its parameters; near: its branches
    calibrated: what the calibrated model leaves"""

    base: Fit
    plan: Plan
    given: Parametrisation
    at: Floats
    near: Sequence[PredictedBranch]
    calibrated: float


def _best_of(about: _About, effect: Effect) -> Probe | None:
    tried = [p for size in effect.sizes if (p := _probe(about, effect, np.array(size))) is not None]
    best = min(tried, key=_misfit, default=None)
    if best is not None and _at_its_end(best):  # what goes as far as it may wants to go further
        again = _probe(about, effect, best.start)
        tried += [] if again is None else [again]
        best = min(tried, key=_misfit)
    if best is None:
        return None
    lowest = min(tried, key=lambda p: p.solved)
    return replace(best, better=(lowest.size,)) if lowest.solved < about.calibrated else best


def _misfit(probe: Probe) -> float:
    return probe.misfit


def _at_its_end(probe: Probe) -> bool:
    return bool(np.max(np.abs(probe.start)) > 0.99 * (1 + REACH))


def highest_levels(plan: Plan) -> tuple[int, ...]:
    """Places of the conditions: the highest level of each mode."""
    highest: dict[str, int] = {}
    for i, condition in enumerate(plan.conditions):
        best = highest.get(condition.mode)
        if best is None or condition.level > plan.conditions[best].level:
            highest[condition.mode] = i
    return tuple(sorted(highest.values()))


def _probe(about: _About, effect: Effect, size: Floats) -> Probe | None:
    """size: (p,) of the effect's parameters in typical ones"""
    base, plan, given = about.base, about.plan, about.given
    extended: Parametrisation = replace(given, effects=(*given.effects, effect))
    scatter = base.compared.scatter
    u = given.with_further(about.at, size)
    u = np.clip(u, extended.lower, extended.upper)
    try:
        options, inflation = coarse_enough(base), base.compared.inflation
        branches = predict_branches(extended, u, plan, about.near, options=options, inflation=inflation)
    except BranchStoppedError:
        return None
    compared = compare_at(extended, u, plan, branches, scatter)
    ahead = fit_linear(extended, plan, compared, scatter, REACH)
    place = extended.columns(effect.name)
    return Probe(effect, ahead.u[place], misfit(extended, ahead), u[place], misfit(extended, compared))
