"""Score test of an effect against a few stated values: how much of what calibration leaves it could take away."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.diagnosis.stated.stated_explanations import Explanation, LowForceProblem, residual_of
from updamp.effects.effect import Effect

Floats = NDArray[np.float64]

_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class StatedScore:
    """score: in standard deviations; visibility: share of the signature that nuisance parameters cannot imitate, 0 to 1
    direction: (n,) of unit length, of the signature orthogonal to them (nil where nothing is left)
    """

    score: float
    visibility: float
    direction: Floats


def stated_score(problem: LowForceProblem, calibrated: Explanation, effect: Effect) -> StatedScore:
    """At the calibrated nuisance parameters; the effect's signature is that of a step to its typical values, one
    parameter after the other. Rows of the priors come after those of the stated values."""
    parametrisation = problem.parametrisation(calibrated.parametrisation.nuisances, (effect,))
    u = np.concatenate([calibrated.u, np.zeros(len(effect.parameters))])
    start, n = residual_of(problem, parametrisation, u), len(calibrated.u)
    columns = [(residual_of(problem, parametrisation, u + s * e) - start) / s
               for e, s in zip(np.eye(len(u)), np.where(np.arange(len(u)) < n, _STEP, 1.0), strict=True)]  # fmt: skip
    J = np.stack(columns, axis=1)
    basis = scipy.linalg.orth(J[:, :n]) if n else np.zeros((len(start), 0))
    own = J[:, n:] - basis @ (basis.T @ J[:, n:])
    left = start - basis @ (basis.T @ start)
    sizes, whole = np.linalg.norm(own, axis=0), np.linalg.norm(J[:, n:], axis=0)
    best = int(np.argmax(sizes))
    if sizes[best] <= 1e-9 * max(float(whole[best]), 1e-300):
        return StatedScore(0.0, 0.0, np.zeros(len(start)))
    projected = own @ np.linalg.lstsq(own, left, rcond=1e-9)[0]
    return StatedScore(float(np.linalg.norm(projected)), float(sizes[best] / whole[best]), own[:, best] / sizes[best])
