"""Score test: how far chi2 would fall, to first order, if an effect were in the model, and how it would look.

C. R. Rao, Proc. Cambridge Phil. Soc. 44 (1948) 50; known as modification index in structural equation models (D.
Soerbom, Psychometrika 54 (1989) 371). Everything is orthogonal to what the nuisance parameters can imitate, as far as
their priors let them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from updamp.comparison.fit.imitated import beyond, imitated
from updamp.diagnosis.score_tests.signature import Extended
from updamp.effects.effect import Effect

Floats = NDArray[np.float64]
# Of an effect of typical size in all data together, in standard deviations.
_ROUND_OFF = 1e-6


@dataclass(frozen=True, eq=False)
class Score:
    """drop: of chi2, the sensors' noise as large as the misfit asks for, to first order and within the bounds
    step: (p,) that brings it, in typical sizes

    visibility: share of the signature that nuisance parameters cannot imitate, 0 to 1
    raw: cosine between residual and signature without orthogonalisation
    signature: (n,) whitened and orthogonal, of the step, or of the typical size where the step is none
    """

    effect: Effect
    drop: float
    step: Floats
    visibility: float
    raw: float
    signature: Floats

    @property
    def score(self) -> float:
        """In standard deviations."""
        return float(np.sqrt(max(self.drop, 0.0)))


def scores(extended: Extended) -> tuple[Score, ...]:
    """Of all further effects, the largest drop first."""
    factor = _of_misfit(extended)
    # what the nuisance parameters can imitate is a matter of the sensors, not of what the model lacks
    visible = {s.effect.name: s.visibility for s in _scores(extended, of_sensors=True)}
    found = _scores(extended, of_sensors=False)
    scaled = (replace(s, drop=factor * s.drop, visibility=visible[s.effect.name]) for s in found)
    return tuple(sorted(scaled, key=lambda s: -s.drop))


def _scores(extended: Extended, of_sensors: bool) -> list[Score]:
    compared, p = extended.compared, extended.parametrisation
    residual, columns = compared.equations(of_sensors)
    of_effects = np.zeros(len(p), dtype=bool)
    for effect in extended.effects:
        of_effects[p.columns(effect.name)] = True
    deviation = p.deviation[~of_effects]
    rows = np.concatenate([residual, -compared.u[~of_effects] / deviation])
    basis = imitated(columns[:, ~of_effects], deviation)
    left = beyond(basis, rows)
    found = []
    for effect in extended.effects:
        place = p.columns(effect.name)
        raw = np.vstack([columns[:, place], np.zeros((len(deviation), place.stop - place.start))])
        bounds = p.lower[place], p.upper[place]
        found.append(_score(effect, raw, beyond(basis, raw), left, rows, bounds))
    return found


def _of_misfit(extended: Extended) -> float:
    """What brings chi2 weighed as in a fit (else nuisance parameters could imitate any effect) to what it is with the
    noise that the misfit asks for (R. T. Birge, Phys. Rev. 40 (1932) 207)."""
    return extended.compared.inflation**2 / max(1.0, extended.compared.mean_squared_misfit)


def _score(
    effect: Effect, raw: Floats, own: Floats, left: Floats, rows: Floats, bounds: tuple[Floats, Floats]
) -> Score:
    if np.linalg.norm(raw) < _ROUND_OFF:  # as a lag where no phase was recorded
        return Score(effect, 0.0, np.zeros(raw.shape[1]), 0.0, 0.0, np.zeros(len(left)))
    size = np.linalg.norm(own, axis=0)
    used = size > 1e-9 * size.max()  # a finite step moves one parameter only
    # parameters of one effect that look alike share the change
    held = 1e-3 * size.max() * np.eye(int(used.sum()))
    scaled = np.vstack([own[:, used], held])
    found = lsq_linear(scaled, np.append(left, np.zeros(len(held))), (bounds[0][used], bounds[1][used]))
    step = np.zeros(len(size))
    step[used] = found.x
    drop = float(left @ left - np.sum((left - own @ step) ** 2))
    size = step if drop > 1e-6 else used.astype(float)
    signature, whole = own @ size, raw @ size
    length = _length(whole)
    visible = _length(signature) / length
    alike = float(abs(whole @ rows)) / (length * _length(rows))
    return Score(effect, drop, step, visible, alike, signature)


def cosines(found: Sequence[Score]) -> Floats:
    """(n, n) between the orthogonal signatures."""
    directions = np.array([s.signature / _length(s.signature) for s in found])
    return np.asarray(directions @ directions.T)


def _length(vector: Floats) -> float:
    """Not nil, so that it can be divided by."""
    return max(float(np.linalg.norm(vector)), 1e-300)
