"""What an effect that has no derivative at its null value does to the observations: by a step to its typical size.

The branch with the effect is moved from the one without it where that works, which takes a fraction of the time of a
trace.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import padded
from updamp.comparison.fit.numerical_gate import in_wider_window
from updamp.comparison.fit.numerical_patterns import change_to, with_unwrapped_phases
from updamp.comparison.prediction.branch_tasks import BranchTask
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions
from updamp.hbm.problem.system import NonlinearSystem
from updamp.parallel.workers import LongestFirst, Workers

Floats = NDArray[np.float64]
# Of the largest force of the elements: a difference below it is round-off.
_NOTHING = 1e-10


@dataclass(frozen=True, eq=False)
class _FiniteStep:
    """branch: of the model without the effect; options: of the continuation"""

    effect: Effect
    branch: PredictedBranch
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
    steps = [_FiniteStep(e, _without_derivatives(b), options) for e in effects for b in solved]
    found = LongestFirst(workers, lambda step: len(step.branch.points))(
        _by_step_of,
        there,
        steps,
        lambda i, _: progress(f"{steps[i].effect.name} along {steps[i].branch.condition.name}"),
    )
    return [[found[j * len(solved) + i] for j in range(len(effects))] for i in range(len(solved))]


def _without_derivatives(branch: PredictedBranch) -> PredictedBranch:
    """Its points are moved by the effect alone."""
    n = len(branch.points)
    nothing = tuple(np.zeros((0, *point.x.shape)) for point in branch.points)
    return replace(branch, u=np.zeros(0), x_by_parameter=nothing, w_by_parameter=np.zeros((n, 0)))


def _by_step_of(there: ModelAt, step: _FiniteStep) -> Floats:
    """(n, n_parameters, m) changes of the observations for all parameters at their typical values.

    Parameters beyond the first have no column of their own: the refit moves them.
    """
    branch, condition, n = step.branch, step.branch.condition, len(step.effect.parameters)
    observed, there = with_unwrapped_phases(branch.observed.value), there.at(condition)
    # the observations have been freed of the numerical error: it is taken off those with the effect too
    numerics = there.parametrisation.numerics.held_at(there.u)
    p = Parametrisation(there.model, (), (step.effect,), numerics)
    for share in (1.0, 0.5, 0.25):
        u = padded(np.full(n, share), len(p))
        try:
            if share == 1 and _leaves_as_it_is(there, p.model(u), branch.points):
                break
            (found,) = BranchTask(p, u, in_wider_window(condition), branch, step.options).predicted()
        except BranchStoppedError:
            continue
        change = change_to(observed, found, condition)[0] / share
        rest = np.zeros((len(change), n - 1, change.shape[1]))
        return np.concatenate([change[:, None], rest], axis=1)
    return np.zeros((len(observed), n, observed.shape[1]))


def _leaves_as_it_is(there: ModelAt, changed: RigModel, points: Sequence[BranchPoint]) -> bool:
    """Whether the points solve the changed model's equations too: it has the same structure, and its elements the same
    forces, as contacts that stick in both. What a trace of it would show then is how branches are interpolated."""
    model = there.model
    structure = changed.components is model.components and changed.attachments == model.attachments
    if not (structure and changed.elements == model.elements):
        return False
    if not set(model.harmonics.orders) <= set(changed.harmonics.orders):
        return False
    return all(_same_forces(model.system, changed.system, there.whole(p.x), p.w) for p in points)


def _same_forces(system: NonlinearSystem, changed: NonlinearSystem, x: Floats, w: float) -> bool:
    """x: (n_relative, n_coefficients) [m], without the harmonics that the changed system has beside"""
    own, wider = system.harmonics, changed.harmonics
    forces = system.element_forces(x, w)
    difference = changed.element_forces(own.among(wider, x), w) - own.among(wider, forces)
    return bool(np.abs(difference).max() <= _NOTHING * np.abs(forces).max())
