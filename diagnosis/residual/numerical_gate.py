"""The first question to a misfit: would finer numerics make it go away?"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.numerical_error import numerical_error
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.model.predicted_branch import PredictedBranch, trace_branch
from updamp.diagnosis.model.rig_model import RigModel
from updamp.diagnosis.residual.observations import Plan
from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]

_MORE_HARMONICS = 2


def more_harmonics(model: RigModel) -> RigModel:
    """The same with two more harmonics and twice the time samples."""
    orders = model.harmonics.orders
    further = tuple(range(orders[-1] + 1, orders[-1] + 1 + _MORE_HARMONICS))
    return replace(model, harmonics=Harmonics((*orders, *further)), time_samples=2 * model.time_samples)


def with_numerical_error(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    finer: Mapping[str, RigModel],
) -> Parametrisation:
    """The parametrisation with a pattern of numerical error for each of the finer models.

    branches: of the parametrisation at u, one a condition; finer: name -> model with the same points
    raises: BranchStoppedError where a finer model has no response at the beginning of a run
    """
    coarse = {b.condition.name: (b.place / b.place[-1], b.at(b.place).value) for b in branches}
    windows = {c.name: c.wider for c in plan.conditions}
    all_finer = []
    for model in finer.values():
        # at u, and with nothing left to differentiate by: the pattern needs the branch alone
        there = Parametrisation(replace(parametrisation, base=model).model(u), ())
        traced = [trace_branch(there, np.zeros(0), c) for c in plan.conditions]
        all_finer.append({b.condition.name: _densely(b) for b in traced})
    return replace(parametrisation, numerics=numerical_error(tuple(finer), windows, coarse, all_finer))


def _densely(branch: PredictedBranch) -> Floats:
    observed = branch.at(np.linspace(branch.place[0], branch.place[-1], 4 * len(branch.place))).value
    observed[:, 2::2] = np.unwrap(observed[:, 2::2], axis=0)
    return observed
