"""The fit with an effect in the model: what decides."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import (
    Compared,
    compare_at,
    misfit,
    objective,
    predict_branches,
)
from updamp.comparison.fit.failing_model import TOLERATED
from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.fit.fit_from_far import LAST, fit_from_far
from updamp.comparison.fit.fit_round import fit_linear
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.offsets import Offsets
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.criteria import Criteria
from updamp.effects.effect import Effect
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions

Floats = NDArray[np.float64]
# Share of it that a start has to bring it down to.
_FAR = 0.1
# How far first order may lead, in units of the scale of each parameter.
REACH = 2.0
COARSE = ContinuationOptions(largest_step=0.4)
_SHORT, FULL = FitOptions(rounds=2, retraced=False), FitOptions()


@dataclass(frozen=True, eq=False)
class Starts:
    """Of the effects' parameters, (p,) each, in typical sizes: beside the model as given, which are tried first, and
    beside the calibrated one."""

    as_given: tuple[Floats, ...]
    calibrated: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class Refit:
    """drop: of the misfit from the baseline (`fit.misfit`); delta_bic: gain of the information criterion by it

    at_bound: parameter that stands at a bound beyond which it makes no sense, "" if none
    own_numerics: whether the numerical error is that of the model with the effects (`baseline.with_own_numerics`)
    ahead: mean squared misfit where one more round would lead to first order, of a fit that was cut short
    also: other minima that the data do not tell from this one (`other_sizes.py`), without their branches
    elsewhere: other minima, which the data do tell from this one (`minima.py`), likewise
    profiles: 95 % intervals by profile likelihood, where they are known: "effect.parameter" -> in its own unit
    """

    effects: tuple[Effect, ...]
    fitted: Fit
    drop: float
    delta_bic: float
    at_bound: str
    own_numerics: bool = False
    ahead: float = np.inf
    also: tuple[Fit, ...] = ()
    elsewhere: tuple[Fit, ...] = ()
    profiles: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def mean_squared_misfit(self) -> float:
        return self.fitted.compared.mean_squared_misfit

    @property
    def promised(self) -> float:
        """Mean squared misfit that the effects may leave, for all that is known of a fit that was cut short"""
        return min(self.mean_squared_misfit, self.ahead)


def refit(
    base: Fit,
    plan: Plan,
    effects: Sequence[Effect],
    starts: Starts,
    criteria: Criteria,
    full: bool,
    near: Fit | None = None,
    given: tuple[Parametrisation, Floats] | None = None,
) -> Refit | None:
    """The fit with further effects, from the most promising start (`_fit_from`). None where the model has no response
    at any.

    Models without contacts are quick to trace: they are always fitted in full, by `fit_from_far`, whatever the starts.

    near: a fit of the same to go on from
    given: the model as given (`Baseline.as_given`), by default with the calibrated one's numerical error
    """
    if near is not None:
        solved = near.compared.branches or None
        again = fit(near.parametrisation, plan, near.u, base.compared.scatter, solved, _options(full))
        return assessed(base, again, plan, effects, criteria)
    p = base.parametrisation
    if p.base.contacts is None:
        nested = _nested(base, plan, replace(p, effects=(*p.effects, *effects)))
        return None if nested is None else assessed(base, nested, plan, effects, criteria)
    at_given = given or (p, p.before_calibration(base.u))
    kinds = [_beside(*at_given, effects, starts.as_given), _beside(p, base.u, effects, starts.calibrated)]
    fitted = _fit_from(base, plan, kinds, full)
    if fitted is None:
        return None
    if full:
        fitted = _no_worse(base, plan, kinds[-1].extended, fitted)
    best = assessed(base, fitted, plan, effects, criteria)
    return best if full else replace(best, ahead=_ahead(fitted, plan))


def _nested(base: Fit, plan: Plan, extended: Parametrisation) -> Fit | None:
    """The best of fits from the model as given, effects absent; where that ends worse than the model that it contains,
    from there too. None where there is no response at any start."""
    p, n = base.parametrisation, extended.n_of_model - base.parametrisation.n_of_model
    contained = objective(p, base.compared)
    best: Fit | None = None
    for values in (np.zeros(n), _shaped(base, plan, extended)):
        if best is not None and (not np.any(values) or best.compared.mean_squared_misfit < 1):
            break
        for u in (p.before_calibration(base.u), base.u):
            try:
                found = fit_from_far(extended, plan, p.with_further(u, values), base.compared.scatter)
            except BranchStoppedError:
                continue
            best = found if best is None or _lower(found, best) else best
            if objective(extended, best.compared) <= contained + LAST.tolerance:
                break
    return best


def _no_worse(base: Fit, plan: Plan, extended: Parametrisation, found: Fit) -> Fit:
    """Where the fit ends worse than the model that it contains, the better one from there, effects absent. On traced
    branches: where a model fails, moved ones are off by more than the two minima differ."""
    if _misfit(found) <= misfit(base.parametrisation, base.compared) + FULL.tolerance:
        return found
    p = base.parametrisation
    absent = p.with_further(base.u, np.zeros(extended.n_of_model - p.n_of_model))
    traced = replace(base.compared, branches=())
    for solved in compared_at(extended, plan, [absent], traced, traced.offsets):
        contained = fit(extended, plan, solved.u, solved.scatter, solved.branches, FULL)
        return contained if _misfit(contained) < _misfit(found) else found
    return found


def _lower(one: Fit, other: Fit) -> bool:
    return objective(one.parametrisation, one.compared) < objective(other.parametrisation, other.compared)


def _shaped(base: Fit, plan: Plan, extended: Parametrisation) -> Floats:
    """Absent effects with those parameters at their typical values that do nothing then, such as an exponent: where
    first order leads to depends on them."""
    p, n = base.parametrisation, base.parametrisation.n_of_model
    at = p.with_further(base.u, np.zeros(extended.n_of_model - n))
    (compared,) = compared_at(extended, plan, [at], replace(base.compared, branches=()))
    columns = compared.equations()[1][:, n : extended.n_of_model]
    return np.where(np.any(columns, axis=0), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class _Kind:
    """Starts beside one model: (p,) parameters with the effects in it each"""

    extended: Parametrisation
    starts: Sequence[Floats]


def _beside(p: Parametrisation, u: Floats, effects: Sequence[Effect], starts: Sequence[Floats]) -> _Kind:
    """u: (p,) of that model without the effects; starts: of these"""
    return _Kind(replace(p, effects=(*p.effects, *effects)), [p.with_further(u, start) for start in starts])


@dataclass(frozen=True, eq=False)
class _Start:
    """solved: where a fit of the parametrisation may begin; promised: misfit where that leads to first order
    (`fit.misfit`); explains: whether that leaves no more than the scatter does"""

    parametrisation: Parametrisation
    solved: Compared
    promised: float
    explains: bool


def _fit_from(base: Fit, plan: Plan, kinds: Sequence[_Kind], full: bool) -> Fit | None:
    """From the most promising start, and from others as long as one promises more than the fits have come to. None
    where there is no response at any.

    kinds: of starts. The calibrated model is a valley of its own: no start beside it is better before it is fitted.
        Those of the second kind are not looked at where one of the first explains the data
    """
    waiting: list[_Start] = []
    best: Fit | None = None
    for place, kind in enumerate(kinds):
        waiting += _starts_of(base, plan, kind)
        if place < len(kinds) - 1 and not any(start.explains for start in waiting):
            continue
        best, waiting = _best_first(best, waiting, plan, _options(full))
        if best is not None and best.compared.mean_squared_misfit <= 1:
            break
    return best


def _starts_of(base: Fit, plan: Plan, kind: _Kind) -> Iterator[_Start]:
    """Up to the first that is better than none; where the model fails badly, far better. Branches are moved from those
    of the calibrated model where these have the same numerical error."""
    before, extended, near = misfit(base.parametrisation, base.compared), kind.extended, base.compared
    if extended.numerics is not base.parametrisation.numerics:
        near = replace(near, branches=())
    for compared in compared_at(extended, plan, kind.starts, near, near.offsets):
        ahead = fit_linear(extended, plan, compared, compared.scatter, REACH)
        yield _Start(extended, compared, misfit(extended, ahead), ahead.mean_squared_misfit <= 1)
        if misfit(extended, compared) < before and _far_better(base, compared.mean_squared_misfit):
            return


def _best_first(
    known: Fit | None, starts: Sequence[_Start], plan: Plan, options: FitOptions
) -> tuple[Fit | None, list[_Start]]:
    """The best fit, and the starts that promise no more than that; known: a fit from another one"""
    best, waiting = known, sorted(starts, key=lambda start: start.promised)
    while waiting and (best is None or waiting[0].promised < _misfit(best)):
        begin, *waiting = waiting
        solved = begin.solved
        found = fit(begin.parametrisation, plan, solved.u, solved.scatter, solved.branches, options)
        best = found if best is None or _misfit(found) < _misfit(best) else best
    return best, waiting


def _misfit(found: Fit) -> float:
    return misfit(found.parametrisation, found.compared)


def compared_at(
    parametrisation: Parametrisation,
    plan: Plan,
    starts: Iterable[Floats],
    near: Compared,
    offsets: Mapping[int, Offsets] | None = None,
) -> Iterator[Compared]:
    """The model at each of the starts, within the bounds, one when it is asked for; where it has no response, none.

    near: whose branches are moved there, whose scatter it is weighed by, and which it need not fit any better than
    """
    for start in starts:
        u = np.clip(start, parametrisation.lower, parametrisation.upper)
        try:
            branches = predict_branches(parametrisation, u, plan, near.branches or None, inflation=near.inflation)
        except BranchStoppedError:
            continue
        yield compare_at(parametrisation, u, plan, branches, near.scatter, offsets)


def coarse_enough(base: Fit) -> ContinuationOptions | None:
    """Of branches that only a first guess depends on. Interpolation between longer steps is off by several times the
    noise of the sensors at most, which is nothing beside what a model lacks that fails badly."""
    return COARSE if fails_badly(base) else None


def fails_badly(base: Fit) -> bool:
    return base.compared.mean_squared_misfit > TOLERATED


def _far_better(base: Fit, mean_squared_misfit: float) -> bool:
    """Whether other starts need not be tried: where the model fails badly, the first that is better is not enough."""
    return not fails_badly(base) or mean_squared_misfit < max(TOLERATED, _FAR * base.compared.mean_squared_misfit)


def _options(full: bool) -> FitOptions:
    return FULL if full else _SHORT


def assessed(base: Fit, found: Fit, plan: Plan, effects: Sequence[Effect], criteria: Criteria) -> Refit:
    drop = misfit(base.parametrisation, base.compared) - misfit(found.parametrisation, found.compared)
    parameters = sum(len(e.parameters) for e in effects)
    delta_bic = gain_of_bic(drop, parameters, plan.independent, plan.as_one)
    return Refit(tuple(effects), found, drop, delta_bic, _at_bound(found, effects, criteria))


def _ahead(found: Fit, plan: Plan) -> float:
    """Mean squared misfit where the next round would lead to first order."""
    reach = _SHORT.largest_step
    ahead = fit_linear(found.parametrisation, plan, found.compared, found.compared.scatter, reach)
    return ahead.mean_squared_misfit


def gain_of_bic(drop: float, parameters: int, independent: float, as_one: float) -> float:
    """Of the Bayesian information criterion (G. Schwarz, Ann. Statist. 6 (1978) 461). Numerics are wrong all along a
    curve, and a thousand points do not ask for an effect that makes up for that: neighbouring points count for less,
    the more so the larger that is beside the noise (`Plan.as_one`)."""
    return drop / as_one - parameters * float(np.log(independent))


def _at_bound(found: Fit, effects: Sequence[Effect], criteria: Criteria) -> str:
    """Bounds at the null value are no such: there the effect is absent; nor are those that make sense themselves."""
    values = found.parametrisation.values(found.u)
    for effect in effects:
        for q in effect.parameters:
            near = criteria.at_bound * (q.upper - q.lower)
            for bound in (q.lower, q.upper):
                if bound not in (q.null, *q.ends) and abs(values[effect.name][q.name] - bound) < near:
                    return f"{effect.name}.{q.name}"
    return ""
