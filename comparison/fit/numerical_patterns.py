"""Patterns of numerical error: what each finer model changes along the branches, by mode and by test, and
how much of that a calibration takes up."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.linear_fit import within_bounds
from updamp.comparison.fit.matching import across
from updamp.comparison.fit.observations import Plan, noise_of
from updamp.comparison.prediction.numerical_error import UNSURE, NumericalError, branch_difference, jaggedness
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition

Floats = NDArray[np.float64]

# Places taken of a finer model's branch for each of its points.
_DENSELY = 40


def with_error_patterns(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    finer: Mapping[str, Mapping[str, PredictedBranch]],
) -> Parametrisation:
    """The parametrisation with a numerical error of these models.

    branches: of the parametrisation at u, one a condition
    finer: name of a finer model -> condition's name -> its branch, where it differs
    """
    conditions = {c.name: c for c in plan.conditions}
    coarse = {b.condition.name: with_unwrapped_phases(b.evenly.value) for b in branches}
    n = parametrisation.n_of_model
    own = {b.condition.name: b.evenly.slopes[:, :n] for b in branches}
    none = {c: np.zeros_like(observed) for c, observed in coarse.items()}
    by_parameter = {c: np.zeros_like(slopes) for c, slopes in own.items()}
    expected, rough = ({c: change.copy() for c, change in none.items()} for _ in range(2))
    names: list[str] = []
    patterns: dict[str, list[Floats]] = {c: [] for c in coarse}
    for name, traced in finer.items():
        found = {c: change_to(coarse[c], b, conditions[c]) for c, b in traced.items()}
        changes = none | {c: change for c, (change, _) in found.items()}
        left = _beyond_calibration(parametrisation, u, plan, branches, changes)
        names += _pattern_names(name, plan)
        for c in conditions:
            if c in found:
                expected[c] += changes[c]
                by_parameter[c] += found[c][1] - own[c]
            patterns[c] += _patterns(changes[c], left[c], c, plan)
            rough[c] = np.hypot(rough[c], jaggedness(changes[c]))
    stacked = {
        c: np.stack(each, axis=1) if each else np.zeros((len(coarse[c]), 0, coarse[c].shape[1]))
        for c, each in patterns.items()
    }
    numerics = NumericalError(tuple(names), coarse, expected, stacked, rough, u[:n], by_parameter)
    return replace(parametrisation, numerics=numerics)


def _pattern_names(finer: str, plan: Plan) -> list[str]:
    return [finer, *(f"{finer} {mode}" for mode in _modes(plan)), *(f"{finer} {c.name}" for c in plan.conditions)]


def _patterns(change: Floats, left: Floats, condition: str, plan: Plan) -> list[Floats]:
    """Of one finer model in one test: its change as a whole; what calibration leaves of that, by mode and by test."""
    mode = next(c.mode for c in plan.conditions if c.name == condition)
    return [
        UNSURE * change,
        *(UNSURE * (mode == other) * left for other in _modes(plan)),
        *(UNSURE * (condition == test.name) * left for test in plan.conditions),
    ]


def _modes(plan: Plan) -> tuple[str, ...]:
    return tuple(dict.fromkeys(c.mode for c in plan.conditions))


def _beyond_calibration(
    parametrisation: Parametrisation,
    u: Floats,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    changes: Mapping[str, Floats],
) -> dict[str, Floats]:
    """Changes of all branches (n, m) less what the parameters make up for, within their bounds and as their priors have
    it.

    What calibration takes up is no error of the calibrated model, whatever it does to the parameters.
    """
    n = parametrisation.n_of_model
    columns, wanted = [np.diag(1 / parametrisation.deviation[:n])], [np.zeros(n)]
    slopes = {}
    for test, branch in enumerate(branches):
        noise = noise_of(plan.observations, test)
        observed = branch.evenly
        slopes[branch.condition.name] = observed.slopes[:, :n]
        basis = across(observed.along, np.broadcast_to(noise, observed.along.shape))
        columns.append(np.einsum("nrm,npm->nrp", basis, observed.slopes[:, :n]).reshape(-1, n))
        wanted.append(np.einsum("nrm,nm->nr", basis, changes[branch.condition.name]).ravel())
    made_up_for = within_bounds(parametrisation, u, np.concatenate(columns), np.concatenate(wanted))
    return {name: change - made_up_for @ slopes[name] for name, change in changes.items()}


def change_to(observed: Floats, traced: PredictedBranch, condition: RunCondition) -> tuple[Floats, Floats]:
    """(n, m) of the observations (n, m) along a branch, by those of another one that was traced further, and that one's
    slopes (n, p, m) by its parameters."""
    densely = traced.at(np.linspace(traced.place[0], traced.place[-1], _DENSELY * len(traced.place)))
    return branch_difference(
        observed, with_unwrapped_phases(densely.value), condition.wider, densely.slopes[:, : len(traced.u)]
    )


def with_unwrapped_phases(observed: Floats) -> Floats:
    """Observations (n, m) along a branch with phases that do not jump."""
    smooth = observed.copy()
    smooth[:, 2::2] = np.unwrap(smooth[:, 2::2], axis=0)
    return smooth
