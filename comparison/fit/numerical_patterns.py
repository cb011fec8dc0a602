"""Patterns of numerical error: what each finer model changes along the branches, by mode and by test, and
how much of that a calibration takes up.

A finer model's change is not in proportion to what it is still off by: where few contact elements slip or open, a test
may by chance hardly change from one mesh to the next. (With two, three and four strips of elements a face the peak of
the virtual rig's OOP at 16 N rises by 1.1 and 0.2 %, that of OOP at 32 N falls by 0.1 % and rises by 0.3 %.) So a
test in which contacts slip or open has, besides its own change, an error by chance: in all ways that calibrated
parameters change it, each as likely, as large as what finer numerics change in other such tests of its mode.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

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
    calibration, of_models = _Calibration(parametrisation, u, plan, branches), list[Mapping[str, Floats]]()
    own = calibration.slopes
    none = {c: np.zeros_like(observed) for c, observed in coarse.items()}
    by_parameter = {c: np.zeros_like(slopes) for c, slopes in own.items()}
    expected, rough = ({c: change.copy() for c, change in none.items()} for _ in range(2))
    names: list[str] = []
    patterns: dict[str, list[Floats]] = {c: [] for c in coarse}
    for name, traced in finer.items():
        found = {c: change_to(coarse[c], b, conditions[c]) for c, b in traced.items()}
        changes = none | {c: change for c, (change, _) in found.items()}
        left = calibration.beyond(changes)
        of_models.append(left)
        names += _pattern_names(name, plan)
        for c in conditions:
            if c in found:
                expected[c] += changes[c]
                by_parameter[c] += found[c][1] - own[c]
            patterns[c] += _patterns(changes[c], left[c], c, plan)
            rough[c] = np.hypot(rough[c], jaggedness(changes[c]))
    further, by_chance = _each_in_its_test(calibration.by_chance(of_models))
    stacked = {
        c: np.concatenate([*(pattern[:, None] for pattern in each), by_chance[c]], axis=1)
        for c, each in patterns.items()
    }
    numerics = NumericalError(
        (*names, *further), coarse, expected, stacked, rough, u[: parametrisation.n_of_model], by_parameter
    )
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


@dataclass(frozen=True, eq=False)
class _Calibration:
    """What the parameters at u make up for of changes along the branches, within their bounds and as their priors have
    it. branches: one a condition"""

    parametrisation: Parametrisation
    u: Floats
    plan: Plan
    branches: Sequence[PredictedBranch]

    @cached_property
    def across(self) -> dict[str, Floats]:
        """Condition's name -> (n, r, m) what takes changes to those across the branch, in standard deviations"""
        found = {}
        for test, branch in enumerate(self.branches):
            along = branch.evenly.along
            noise = noise_of(self.plan.observations, test)
            found[branch.condition.name] = across(along, np.broadcast_to(noise, along.shape))
        return found

    @cached_property
    def slopes(self) -> dict[str, Floats]:
        """Condition's name -> (n, p, m) by the parameters of the model"""
        n = self.parametrisation.n_of_model
        return {b.condition.name: b.evenly.slopes[:, :n] for b in self.branches}

    @cached_property
    def columns(self) -> dict[str, Floats]:
        """Condition's name -> (n r, p) of the slopes across its branch, in standard deviations"""
        return {
            name: np.einsum("nrm,npm->nrp", self.across[name], slopes).reshape(-1, slopes.shape[1])
            for name, slopes in self.slopes.items()
        }

    def seen(self, condition: str, change: Floats) -> Floats:
        """(n r,) of a change (n, m) likewise"""
        return np.einsum("nrm,nm->nr", self.across[condition], change).ravel()

    def beyond(self, changes: Mapping[str, Floats]) -> dict[str, Floats]:
        """Changes of all branches (n, m) less what the parameters make up for: what calibration takes up is no error of
        the calibrated model, whatever it does to the parameters."""
        n = self.parametrisation.n_of_model
        columns = np.concatenate([np.diag(1 / self.parametrisation.deviation[:n]), *self.columns.values()])
        wanted = np.concatenate([np.zeros(n), *(self.seen(name, changes[name]) for name in self.columns)])
        made_up_for = within_bounds(self.parametrisation, self.u, columns, wanted)
        return {name: change - made_up_for @ self.slopes[name] for name, change in changes.items()}

    def by_chance(self, left: Sequence[Mapping[str, Floats]]) -> dict[str, Floats]:
        """Condition's name -> (n, k, m) what is by chance in it, as the other tests tell: nothing where all contacts
        stick.

        left: of each finer model, what calibration leaves of its changes (n, m) of all branches
        """
        slipping = [b.condition for b in self.branches if not b.proportional]
        variance = {
            c.name: sum(float(np.mean(self.seen(c.name, of_model[c.name]) ** 2)) for of_model in left) for c in slipping
        }
        found = {b.condition.name: np.zeros((len(b.evenly.along), 0, b.evenly.along.shape[1])) for b in self.branches}
        for c in slipping:
            others = [variance[o.name] for o in slipping if o.mode == c.mode and o.name != c.name]
            if any(others):
                found[c.name] = self._each_way(c.name, UNSURE * float(np.sqrt(np.mean(others))))
        return found

    def _each_way(self, condition: str, size: float) -> Floats:
        """(n, k, m) independent changes that the nuisance parameters can make of a test, which together have this root
        mean square, in standard deviations"""
        p = len(self.parametrisation.nuisances)
        columns = self.columns[condition][:, :p]
        _, lengths, ways = np.linalg.svd(columns, full_matrices=False)
        felt = lengths > lengths.max(initial=0.0) * np.sqrt(np.finfo(float).eps)
        scaled = size * np.sqrt(len(columns) / max(felt.sum(), 1)) * ways[felt] / lengths[felt, None]
        return np.einsum("kp,npm->nkm", scaled, self.slopes[condition][:, :p])


def _each_in_its_test(by_chance: Mapping[str, Floats]) -> tuple[list[str], dict[str, Floats]]:
    """Names, and condition's name -> patterns (n, all k, m), zero where they are another test's

    by_chance: condition's name -> (n, k, m)
    """
    names: list[str] = []
    found, several = {}, sum(ways.shape[1] for ways in by_chance.values())
    for c, ways in by_chance.items():
        found[c] = np.zeros((len(ways), several, ways.shape[2]))
        found[c][:, len(names) : len(names) + ways.shape[1]] = ways
        names += [f"{c} by chance {k + 1}" for k in range(ways.shape[1])]
    return names, found


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
