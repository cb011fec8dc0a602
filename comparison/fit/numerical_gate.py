"""The numerical gate, the first question to a misfit: would finer numerics make it go away?

The model is solved with more harmonics and time samples, and on finer meshes. What that changes is added to the model,
its uncertainty enters the fit as patterns (`numerical_error.py`). How far it may have
moved the parameters is in their deviations (`Fit.uncertainty`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import padded, predict_branches
from updamp.comparison.fit.numerical_patterns import with_error_patterns
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.branch_tasks import Branches, BranchTask, in_turn
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, with_patterns
from updamp.comparison.prediction.run_condition import RunCondition, same_sweeps
from updamp.effects.rig_model import RigModel
from updamp.hbm.analysis.settings import Setting, more_harmonics, twice_the_samples
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]

# Name of the model with more harmonics and time samples.
HARMONICS = "harmonics"
# How far the finer model's harmonics reach beyond the highest. Half of what they change counts as uncertainty, so they
# need not settle it.
_FURTHER_ORDERS = 2
# A finer model is traced beyond the measured window by this share of it.
_FURTHER = 0.4


def with_finer_harmonics(model: RigModel) -> RigModel:
    """The same with harmonics continued by two orders (`more_harmonics`) and twice the time samples."""
    setting = Setting(model.harmonics.orders, model.time_samples)
    finer = more_harmonics(twice_the_samples(setting), _FURTHER_ORDERS)
    return replace(model, harmonics=Harmonics(finer.orders), time_samples=finer.time_samples)


def finer_than(model: RigModel, finer: Mapping[str, RigModel]) -> dict[str, RigModel]:
    """The models of finer meshes, and the same with more harmonics and time samples."""
    return {HARMONICS: with_finer_harmonics(model), **finer}


@dataclass(frozen=True, eq=False)
class NumericalGate:
    """plan: all runs; finer: models with finer numerics, by name, without effects of the rig file
    widened: how often at most the windows of the model's own branches are widened by what finer ones shift: one that is
        half-way to its resonance shifts otherwise than at it
    """

    plan: Plan
    finer: Mapping[str, RigModel]
    branches_of: Branches = in_turn
    widened: int = 3

    def at(
        self,
        plain: Parametrisation,
        u: Floats,
        solved: Sequence[PredictedBranch] = (),
    ) -> "Asked":
        """What finer numerics change at parameters u. Where they shift the response by more than the measured window
        has room for, the model's own is solved that much farther: what changes at its resonance is not seen on a flank.

        plain: without numerical error; u: (p,) where that is asked for
        solved: branches of some of the tests at u, whatever their numerical error. Those of finer models are always
            traced: moved from where they were, one of two tests ended 3.8 deviations off
        raises: BranchStoppedError where a model has no response at the beginning of a run
        """
        near = {b.condition.name: b for b in solved}
        starts = [near.get(c.name) for c in self.plan.conditions]
        branches = predict_branches(plain, u, self.plan, starts, self.branches_of)
        finer = self._finer(plain, u, branches)
        found = with_error_patterns(plain, u, self.plan, branches, finer)
        for _ in range(self.widened):
            windows = [found.numerics.solved_window(c.name, c.window, u) for c in self.plan.conditions]
            short = [i for i, branch in enumerate(branches) if not branch.covers(windows[i])]
            if not short:
                break
            conditions = tuple(replace(self.plan.conditions[i], solved=windows[i]) for i in short)
            wider = predict_branches(plain, u, replace(self.plan, conditions=conditions), None, self.branches_of)
            known = dict(zip(short, wider, strict=True))
            branches = tuple(known.get(i, branch) for i, branch in enumerate(branches))
            more = self._finer(plain, u, wider)
            finer = {name: {**finer.get(name, {}), **more.get(name, {})} for name in self.finer}
            found = with_error_patterns(plain, u, self.plan, branches, finer)
        return Asked(found, branches)

    def beginning(
        self, plain: Parametrisation, u: Floats, training: Sequence[int], solved: Sequence[PredictedBranch] = ()
    ) -> "Beginning":
        """Of a fit, with what finer numerics change there; training: places of the tests that it sees; else as
        `at`"""
        asked, train = self.at(plain, u, solved), self.plan.only(training)
        found, seen = asked.parametrisation, [asked.branches[i] for i in training]
        start = padded(u, len(found))
        return Beginning(found, start, starting_at(found, start, train, seen, self.branches_of))

    def _finer(self, plain: Parametrisation, u: Floats, branches: Sequence[PredictedBranch]) -> "Finer":
        tasks = _tasks(plain, u, branches, self.finer)
        traced = self.branches_of([task for of_model in tasks.values() for task in of_model])
        return _by_model(tasks, traced)


# Finer model's name -> condition's name -> its branch, where it differs
Finer = Mapping[str, Mapping[str, PredictedBranch]]


@dataclass(frozen=True, eq=False)
class Asked:
    """What finer numerics change at some parameters. parametrisation: with that error; branches: without it, one a
    condition"""

    parametrisation: Parametrisation
    branches: tuple[PredictedBranch, ...]


@dataclass(frozen=True, eq=False)
class Beginning:
    """u: (p,) with the patterns' sizes, which are 0; branches: at u, with the numerical error, one a test of the fit"""

    parametrisation: Parametrisation
    u: Floats
    branches: tuple[PredictedBranch, ...]


def starting_at(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    branches_of: Branches = in_turn,
) -> tuple[PredictedBranch, ...]:
    """Branches with the parametrisation's numerical error; traced further where they do not cover what was measured any
    more.

    branches: at u without that error, one a condition; u: (p,) with the patterns' sizes, which are 0
    raises: BranchStoppedError where one has no beginning
    """
    found = [with_patterns(branch, parametrisation.numerics) for branch in branches]
    short = [i for i, branch in enumerate(found) if not branch.covers_window]
    for i, branch in zip(short, predict_branches(parametrisation, u, plan.only(short), None, branches_of), strict=True):
        found[i] = branch
    return tuple(found)


def _tasks(
    parametrisation: Parametrisation,
    u: Floats,
    branches: Sequence[PredictedBranch],
    models: Mapping[str, RigModel],
) -> dict[str, list[BranchTask]]:
    """Model's name -> tasks, in wider windows, for the conditions where it differs."""
    found = {}
    for name, model in models.items():
        there = replace(parametrisation, base=model, numerics=NumericalError())
        conditions = [b.condition for b in branches if _differs(model, parametrisation.base, b)]
        together = ([conditions[i] for i in group] for group in same_sweeps(conditions))
        found[name] = [_finer_task(there, u, group) for group in together]
    return {name: tasks for name, tasks in found.items() if tasks}


def _differs(model: RigModel, base: RigModel, branch: PredictedBranch) -> bool:
    """Harmonics and time samples change nothing where the response is that of a linear model, all contacts stuck: what
    the two branches are apart there is how they are interpolated."""
    linear = branch.proportional or not (model.groups or base.groups)
    return not (linear and model.components is base.components)


def _finer_task(
    of_model: Parametrisation,
    u: Floats,
    conditions: Sequence[RunCondition],
) -> BranchTask:
    """conditions: tests that sweep the same branch"""
    first, *others = (in_wider_window(condition) for condition in conditions)
    return BranchTask(of_model, u, first, others=tuple(others))


def _by_model(
    tasks: Mapping[str, Sequence[BranchTask]], traced: Sequence[PredictedBranch]
) -> dict[str, dict[str, PredictedBranch]]:
    """Model's name -> condition's name -> its branch; traced: of all tasks, in their order"""
    following = iter(traced)
    return {
        name: {condition.name: next(following) for task in of_model for condition in task.conditions}
        for name, of_model in tasks.items()
    }


def in_wider_window(condition: RunCondition) -> RunCondition:
    """Finer numerics, or an effect, may shift the resonance by more than its width."""
    low, high = condition.window
    return replace(condition, window=(low - _FURTHER * (high - low), high + _FURTHER * (high - low)))
