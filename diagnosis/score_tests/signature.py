"""What each effect would do to the observations, to first order about a calibrated model that does not have it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import interp1d

from updamp.comparison.fit.compared import Compared, compare_at, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.branch_tasks import Branches, BranchesBy
from updamp.comparison.prediction.derivatives import Change
from updamp.comparison.prediction.model_at import ModelAt, change_of_effect
from updamp.comparison.prediction.observed_point import with_matrices
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, of_state
from updamp.comparison.prediction.traced_branch import observe
from updamp.diagnosis.candidate_models.refit import coarse_enough
from updamp.diagnosis.score_tests.finite_steps import steps_along
from updamp.effects.effect import Effect
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Extended:
    """A calibrated model with further effects at their null values.

    compared: with one column for each of their parameters, after those of the parametrisation's own effects
    effects: those that the model has a place for; refused: name -> why it has none
    """

    parametrisation: Parametrisation
    compared: Compared
    effects: tuple[Effect, ...]
    refused: dict[str, str]

    def answer(self, effect: Effect, step: Floats) -> Floats:
        """(p,) the effect's step, and what the nuisance parameters do to make up for it as far as they can."""
        _, columns = self.compared.equations()
        p, place = self.parametrisation, self.parametrisation.columns(effect.name)
        first, n = len(p.nuisances), p.n_of_model
        free = np.r_[0:first, n : len(p)]
        prior = np.diag(1 / p.deviation[free])
        wanted = np.concatenate([columns[:, place] @ step, np.zeros(len(free))])
        made_up = np.linalg.lstsq(np.vstack([columns[:, free], prior]), wanted, rcond=None)[0]
        found = np.zeros(len(p))
        found[place], found[free] = step, -made_up
        return found


def extend(
    fitted: Fit,
    plan: Plan,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
    workers: Workers = here,
) -> Extended:
    """The fit's model with signatures of the effects as further columns.

    An effect that cannot be differentiated at its null value is traced at its typical one: its column is the
    difference over the whole step.
    """
    p, u = fitted.parametrisation, fitted.u
    there = ModelAt(p, u)
    known, refused = _with_a_place(there, effects)
    by_step = [e for e in known if _needs_step(there, e)]
    by_derivative = [e for e in known if e not in by_step]
    n_changes = sum(len(e.parameters) for e in by_derivative)
    progress(f"signatures of {len(known)} effects")
    solved = _solved_at(fitted, plan, BranchesBy(workers))
    steps = steps_along(there, solved, by_step, coarse_enough(fitted), progress, workers)
    shared = there, _changes(there, by_derivative, [b.condition.place for b in solved])
    differentiated = workers(_differentiated, shared, solved, lambda i, _: progress(_step_name(solved[i])))
    branches = [_with_steps(there, b, n_changes, own) for b, own in zip(differentiated, steps, strict=True)]
    ordered = (*by_derivative, *by_step)
    extended = replace(p, effects=(*p.effects, *ordered))
    longer = p.with_further(u, np.zeros(extended.n_of_model - p.n_of_model))
    compared = compare_at(extended, longer, plan, branches, fitted.compared.scatter, fitted.compared.offsets)
    return Extended(extended, compared, ordered, refused)


def _changes(there: ModelAt, effects: Sequence[Effect], places: Sequence[float]) -> dict[float, list[Change]]:
    """By each parameter of each effect, at each place among the runs of an assembly (`RunCondition.place`); the same
    ones at all of them where the place does not matter."""
    wanted = [(effect, parameter) for effect in effects for parameter in effect.parameters]
    runs_in = there.parametrisation.runs_in
    moving = {e.name for e in effects if e.apply(there.model, e.at_typical()).running_in != 0}
    models = {place: replace(there, place=place) if runs_in else there for place in places}

    @cache
    def change(which: int, place: float) -> Change:
        return change_of_effect(models[place], *wanted[which], place)

    def own(effect: Effect, place: float) -> float:
        return place if runs_in or effect.name in moving else places[0]

    return {place: [change(i, own(e, place)) for i, (e, _) in enumerate(wanted)] for place in models}


def _step_name(branch: PredictedBranch) -> str:
    return f"signatures along {branch.condition.name}"


def _solved_at(fitted: Fit, plan: Plan, branches_of: Branches) -> tuple[PredictedBranch, ...]:
    """Branches of the fit's parameters: a fit that has settled is a linear step beyond those that it solved last."""
    p, u, branches = fitted.parametrisation, fitted.u, fitted.compared.branches
    n = p.n_of_model
    if all(np.array_equal(branch.u[:n], u[:n]) for branch in branches):
        return branches
    return predict_branches(p, u, plan, branches, branches_of, inflation=fitted.compared.inflation)


def _with_a_place(there: ModelAt, effects: Sequence[Effect]) -> tuple[list[Effect], dict[str, str]]:
    known, refused = [], {}
    for effect in effects:
        try:
            _ = effect.apply(there.model, effect.at_typical()).system
        except (ValueError, KeyError, AssertionError) as error:
            refused[effect.name] = str(error)
        else:
            known.append(effect)
    return known, refused


def _needs_step(there: ModelAt, effect: Effect) -> bool:
    """Whether it has no derivative at its null value, other harmonics beside it, or takes a symmetry that half of the
    model was solved for."""
    changed = effect.apply(there.model, effect.at_typical())
    return effect.finite_step or changed.harmonics != there.model.harmonics or not there.keeps_symmetry(changed)


def _differentiated(shared: tuple[ModelAt, Mapping[float, list[Change]]], branch: PredictedBranch) -> PredictedBranch:
    """The branch with columns for changes of its model, before those of the numerical error.

    What changes do varies along a branch as what is observed does, without the corners that a comparison has points
    for: of these some are left out.
    """
    there, changes = shared[0].at(branch.condition), shared[1][branch.condition.place]
    some = branch.spread_out()
    points = with_matrices(there, branch.condition, [branch.points[i] for i in some])
    seen = observe(there, branch.condition, points, branch.stopped, changes)
    n = there.parametrisation.n_of_model
    columns = interp1d(branch.place[some], seen.slopes[:, n : n + len(changes)], axis=0)(branch.place)
    slopes = np.concatenate([branch.slopes[:, :n], columns, branch.slopes[:, n:]], axis=1)
    u = np.concatenate([branch.u[:n], np.zeros(len(changes)), branch.u[n:]])
    return replace(branch, u=u, slopes=slopes)


def _with_steps(there: ModelAt, found: PredictedBranch, n_changes: int, steps: Sequence[Floats]) -> PredictedBranch:
    """The branch with columns for all parameters of the effects, before those of the numerical error."""
    if not steps:
        return found
    n = there.parametrisation.n_of_model + n_changes
    columns = of_state(np.concatenate(steps, axis=1), found.state)
    slopes = np.concatenate([found.slopes[:, :n], columns, found.slopes[:, n:]], axis=1)
    u = np.concatenate([found.u[:n], np.zeros(columns.shape[1]), found.u[n:]])
    return replace(found, u=u, slopes=slopes)
