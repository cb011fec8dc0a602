"""Where the search starts: the model without further effects, calibrated to some runs, others kept for judging."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from updamp.diagnosis.effects.chosen import ChosenEffect
from updamp.diagnosis.model.parameters import LOSS_FACTOR
from updamp.diagnosis.model.predicted_branch import with_patterns
from updamp.diagnosis.model.rig_model import RigModel
from updamp.diagnosis.residual.fit import Fit, FitOptions, compare_at, fit, predict
from updamp.diagnosis.residual.matching import Matched
from updamp.diagnosis.residual.numerical_gate import gated
from updamp.diagnosis.residual.observations import Plan
from updamp.diagnosis.residual.scatter import Assembly, Scatter, learn

Floats = NDArray[np.float64]
# Fewest levels of a mode of which one is kept for judging.
_ENOUGH = 3
_ROUNDS = FitOptions(rounds=4)
# Of a smooth curve along a branch.
_PIECES = 8
# Share of the largest singular value below which a direction is none of its own.
_DEPENDENT = 1e-6


@dataclass(frozen=True, eq=False)
class Baseline:
    """plan: all runs; training, held_out: places of its conditions

    fitted: to the training runs, with the scatter that the repeats alone show
    repeatability: weighted residual RMS of what differs between the repeats
    finer: models of finer meshes, without effects, by name
    """

    plan: Plan
    training: tuple[int, ...]
    held_out: tuple[int, ...]
    fitted: Fit
    repeatability: float
    finer: Mapping[str, RigModel] = field(default_factory=dict)

    @property
    def train_plan(self) -> Plan:
        return self.plan.only(self.training)

    @property
    def held_out_plan(self) -> Plan:
        return self.plan.only(self.held_out)


def baseline(
    model: RigModel,
    taken: tuple[ChosenEffect, ...],
    plan: Plan,
    finer: Mapping[str, RigModel],
    held_out: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Numerical gate and calibration.

    held_out: names of runs that no fit sees; by default one level of each mode that was measured at three or more
    raises: BranchStoppedError where the model has no response at the beginning of a run; ValueError for a run that
        was not measured
    """
    kept = _held_out(plan, held_out)
    training = tuple(i for i in range(len(plan.conditions)) if i not in kept)
    parametrisation, before = gated(model, taken, plan, finer, progress)
    train = plan.only(training)
    at_start = tuple(with_patterns(before[i], parametrisation.numerics) for i in training)
    start = np.zeros(len(parametrisation))
    progress("calibration")
    first = fit(parametrisation, train, start, None, at_start, _ROUNDS, progress)
    scatter, repeatability = scatter_of_repeats(first, train)
    found = fit(parametrisation, train, first.u, scatter, first.compared.branches, _ROUNDS, progress)
    return Baseline(plan, training, kept, found, repeatability, finer)


def _held_out(plan: Plan, names: Sequence[str] | None) -> tuple[int, ...]:
    """Places of the conditions: the second highest level of each mode, if not said otherwise."""
    if names is not None:
        known = [c.name for c in plan.conditions]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise ValueError(f"no run '{unknown[0]}' to hold out; there are {', '.join(known)}")
        return tuple(i for i, name in enumerate(known) if name in names)
    kept: list[int] = []
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        levels = sorted({c.level for c in plan.conditions if c.mode == mode})
        if len(levels) >= _ENOUGH:
            kept += [i for i, c in enumerate(plan.conditions) if c.mode == mode and c.level == levels[-2]]
    return tuple(sorted(kept))


def scatter_of_repeats(fitted: Fit, plan: Plan) -> tuple[Scatter, float]:
    """The scatter with what all repeats have in common left out, and the RMS of what they do not.

    A misfit of the model is common to all repeats, whatever its shape along a curve. So frequency, damping, the
    sensors' amplitudes and phases of every run, and beyond that a smooth curve for every residual, may be anything
    here, or the scatter would grow until the misfit is one of its draws. Sensors' noise is what the runs' roughness
    says.
    """
    p, compared = fitted.parametrisation, fitted.compared
    loss = p.names.index(LOSS_FACTOR.name)
    curves = [_curves([m for m in compared.matched if m.observations.test == i]) for i in range(len(plan.conditions))]
    freed = []
    for a in compared.assemblies:
        of_repeat = [m for m in compared.matched if m.observations.repeat == a.repeat]
        blocks = scipy.linalg.block_diag(
            *(np.concatenate([_free(m, loss), curves[m.observations.test](m)], axis=1) for m in of_repeat)
        )
        freed.append(replace(a, common=np.concatenate([a.common, blocks], axis=1)))
    if len(freed) < 2:
        return replace(compared.scatter, noise=1.0), 1.0
    freed = _independent(freed)
    # what is rough about a large misfit is no scatter either
    learnt = learn(freed, Scatter({n.name: n.scatter for n in p.nuisances}, noise=max(1.0, _roughness(freed))))
    return replace(learnt, noise=1.0), learnt.noise


def _independent(assemblies: Sequence[Assembly]) -> list[Assembly]:
    """The same with common directions that do not depend on each other: many are there twice, and which of them the
    data tell would else change with the last digits."""
    common = np.concatenate([a.common for a in assemblies])
    size = np.maximum(np.linalg.norm(common, axis=0), np.finfo(float).tiny)
    basis = scipy.linalg.orth(common / size, rcond=_DEPENDENT)
    ends = np.cumsum([len(a.residual) for a in assemblies])[:-1]
    return [replace(a, common=part) for a, part in zip(assemblies, np.split(basis, ends), strict=True)]


def _roughness(assemblies: Sequence[Assembly]) -> float:
    """RMS of what neither the common nor the random directions of an assembly take up."""
    left, values = 0.0, 0
    for a in assemblies:
        basis = scipy.linalg.orth(np.column_stack([a.common, a.random]))
        left += float(np.sum((a.residual - basis @ (basis.T @ a.residual)) ** 2))
        values += len(a.residual) - basis.shape[1]
    return float(np.sqrt(left / max(values, 1)))


def _free(m: Matched, loss: int) -> Floats:
    """(values of the run, directions)"""
    columns = [m.by_observation[:, :, j].ravel() for j in range(m.by_observation.shape[2])]
    columns.append(m.by_parameter[:, :, loss].ravel())
    return np.stack(columns, axis=1)


def _curves(of_test: Sequence[Matched]) -> Callable[[Matched], Floats]:
    """A basis (values of a run, directions) of smooth curves along the branch, one for each residual, the same for all
    repeats of a test: cubic splines."""
    places = np.concatenate([m.place for m in of_test])
    low, high = places.min(), places.max()
    knots = np.concatenate([[low] * 3, np.linspace(low, high, _PIECES + 1), [high] * 3])

    def basis(m: Matched) -> Floats:
        along = BSpline.design_matrix(np.clip(m.place, low, high), knots, 3).toarray()
        return np.asarray(np.kron(along, np.eye(m.residual.shape[1])), dtype=np.float64)

    return basis


def error_of(fitted: Fit, plan: Plan) -> float:
    """Weighted residual RMS on runs that the fit may not have seen, parameters and scatter as they are."""
    if not plan.conditions:
        return float("nan")
    branches = predict(fitted.parametrisation, fitted.u, plan)
    compared = compare_at(fitted.parametrisation, fitted.u, plan, branches, fitted.compared.scatter)
    return float(np.sqrt(compared.excess))
