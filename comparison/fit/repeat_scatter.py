"""The scatter that the repeats alone show, whatever the model gets wrong."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Assembly, Scatter, learn
from updamp.model.calibration import LOSS_FACTOR

Floats = NDArray[np.float64]
# Of a smooth curve along a branch.
_PIECES = 8
# Share of the largest singular value below which a direction is none of its own.
_DEPENDENT = 1e-6


def scatter_of_repeats(fitted: Fit, plan: Plan) -> tuple[Scatter, float]:
    """The scatter with what all repeats have in common left out, and the RMS of what they do not.

    A misfit of the model is common to all repeats, whatever its shape along a curve. So frequency, damping, the
    sensors' amplitudes and phases of every run, and beyond that a smooth curve for every residual, may be anything
    here, or the scatter would grow until the misfit is one of its draws. The sensors' noise is as the plan has it.
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
    sizes = {n.name: n.scatter for n in p.nuisances}
    prior = Scatter(sizes, plan.drift, plan.gain, plan.level, max(1.0, _roughness(freed)))
    learnt = learn(freed, prior, furthest=np.inf)
    return replace(learnt, noise=1.0), learnt.noise


def of_repeats(fit: Fit, plan: Plan) -> Scatter:
    """What the repeats alone show; that of the fit where there are none."""
    if len(fit.compared.assemblies) < 2:
        return fit.compared.scatter
    scatter, repeatability = scatter_of_repeats(fit, plan)
    return replace(scatter, noise=scatter.noise * repeatability)


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
