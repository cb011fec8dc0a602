"""What an effect that has no derivative at its null value does to the observations: by a step to its typical size."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.numerical_gate import change_of_branch
from updamp.comparison.fit.numerical_patterns import with_unwrapped_phases
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions
from updamp.hbm.problem.system import NonlinearSystem
from updamp.parallel.workers import LongestFirst, Workers

Floats = NDArray[np.float64]
# Of the largest force of the elements: a difference below it is round-off.
_NOTHING = 1e-10


@dataclass(frozen=True, eq=False)
class _FiniteStep:
    """observed: (n, m) along a branch of the model without the effect; options: of the continuation
    motions: relative displacements (n_relative, n_coefficients) [m] and angular frequency [rad/s] of its points
    """

    effect: Effect
    condition: RunCondition
    observed: Floats
    motions: tuple[tuple[Floats, float], ...]
    options: ContinuationOptions | None


def steps_along(
    there: ModelAt,
    solved: Sequence[PredictedBranch],
    effects: Sequence[Effect],
    options: ContinuationOptions | None,
    progress: Callable[[str], None],
    workers: Workers,
) -> list[list[Floats]]:
    """For each branch of the model without the effects the changes (n, n_parameters, m) by each of them, as
    `_by_step_of`.

    options: of the continuation
    """
    steps = [
        _FiniteStep(
            e, b.condition, with_unwrapped_phases(b.observed.value), tuple((p.x, p.w) for p in b.points), options
        )
        for e in effects
        for b in solved
    ]
    found = LongestFirst(workers, lambda step: len(step.observed))(
        _by_step_of, there, steps, lambda i, _: progress(f"{steps[i].effect.name} along {steps[i].condition.name}")
    )
    return [[found[j * len(solved) + i] for j in range(len(effects))] for i in range(len(solved))]


def _by_step_of(there: ModelAt, step: _FiniteStep) -> Floats:
    """(n, n_parameters, m) changes of the observations for all parameters at their typical values.

    Parameters beyond the first have no column of their own: the refit moves them.
    """
    effect, observed, numerics = step.effect, step.observed, there.parametrisation.numerics.held_at(there.u)
    there = there.at(step.condition)
    for share in (1.0, 0.5, 0.25):
        values = {q.name: q.null + share * (q.typical - q.null) for q in effect.parameters}
        try:
            changed = effect.apply(there.model, values)
            if share == 1 and _leaves_as_it_is(there, changed, step.motions):
                break
            change = change_of_branch(changed, step.condition, observed, numerics, step.options) / share
        except BranchStoppedError:
            continue
        rest = np.zeros((len(change), len(effect.parameters) - 1, change.shape[1]))
        return np.concatenate([change[:, None], rest], axis=1)
    return np.zeros((len(observed), len(effect.parameters), observed.shape[1]))


def _leaves_as_it_is(there: ModelAt, changed: RigModel, motions: Sequence[tuple[Floats, float]]) -> bool:
    """Whether the motions solve the changed model's equations too: it has the same structure, and its elements the same
    forces, as contacts that stick in both. What a trace of it would show then is how branches are interpolated."""
    model = there.model
    structure = changed.components is model.components and changed.attachments == model.attachments
    if not (structure and changed.elements == model.elements):
        return False
    if not set(model.harmonics.orders) <= set(changed.harmonics.orders):
        return False
    return all(_same_forces(model.system, changed.system, there.whole(x), w) for x, w in motions)


def _same_forces(system: NonlinearSystem, changed: NonlinearSystem, x: Floats, w: float) -> bool:
    """x: (n_relative, n_coefficients) [m], without the harmonics that the changed system has beside"""
    places = [(system.harmonics.slices[k], changed.harmonics.slices[k]) for k in system.harmonics.orders]
    wider = np.zeros((len(x), changed.harmonics.n_coefficients))
    for own, other in places:
        wider[:, other] = x[:, own]
    forces, difference = system.element_forces(x, w), changed.element_forces(wider, w)
    for own, other in places:
        difference[:, other] -= forces[:, own]
    return bool(np.abs(difference).max() <= _NOTHING * np.abs(forces).max())
