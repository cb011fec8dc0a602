"""What could explain stated resonance frequencies: nuisance parameters, effects, both, and pairs of effects.

The stated values are few, and taken at forces so small that no contact slips: every model is solved as a linear one
(`small_amplitude`), so that each explanation can be searched over the whole of its bounds.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.stated.low_force_modes import LowForceModes
from updamp.effects.chosen import ChosenEffect
from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.measurement.measurement import Feature
from updamp.model.calibration import NORMAL, TANGENTIAL, Nuisance, nuisances

Floats = NDArray[np.float64]
Progress = Callable[[str], None]

# A stated value is met within this many of its standard deviations, and a nuisance parameter believed within as many.
MET = 3.0
# Share of its scale that a parameter is moved by for a derivative, and least relative change of frequency that counts.
_STEP, _MOVES = 1e-3, 1e-5
# Where a search over an effect's bounds looks first: shares of the way to each.
_SHARES = (0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0)
_STARTS = 2
_AS_GOOD, _LEVEL = 4.0, 1e-6  # of chi2, above the best


def _both(model: RigModel, factor: float) -> RigModel:
    return NORMAL.apply(TANGENTIAL.apply(model, factor), factor)


CONTACT = replace(NORMAL, name="contact_stiffness", sentence="contact stiffness in all directions", apply=_both)


@dataclass(frozen=True, eq=False)
class LowForceProblem:
    """features: stated values that hold at small force; modes: which modes they are of; rig_effects: effects of the rig
    file; each is compared in its standard deviations"""

    base: RigModel
    features: tuple[Feature, ...]
    modes: LowForceModes
    rig_effects: tuple[ChosenEffect, ...] = ()

    def parametrisation(self, chosen: Sequence[Nuisance], effects: Sequence[Effect] = ()) -> Parametrisation:
        return Parametrisation(self.base, tuple(chosen), tuple(effects), rig_effects=self.rig_effects)

    def frequencies(self, model: RigModel) -> Floats:
        """(n_features,) [Hz]"""
        return self.modes.frequencies(model, [f.mode for f in self.features])

    @cached_property
    def stated(self) -> Floats:
        return np.array([f.value for f in self.features])

    @cached_property
    def deviation(self) -> Floats:
        """[Hz]"""
        return self.stated * np.array([f.relative_uncertainty for f in self.features])


@dataclass(frozen=True, eq=False)
class Explanation:
    """name: of what is changed, in words; u, covariance: of the parametrisation, as fitted
    frequencies: (n_features,) [Hz]; off: (n_features,) from the stated values, in their standard deviations
    chi2: with what the priors of the nuisance parameters add
    as_good: other places, one parameter of an effect moved, that fit within two standard deviations: contacts open
        one after the other, so that a derivative does not tell how far a parameter is free
    """

    name: str
    parametrisation: Parametrisation
    u: Floats
    covariance: Floats
    frequencies: Floats
    off: Floats
    chi2: float
    as_good: tuple[Floats, ...] = ()

    @property
    def met(self) -> bool:
        """Every stated value, with nuisance parameters that can be believed."""
        n = len(self.parametrisation.nuisances)
        strange = np.abs(self.u[:n]) > MET * self.parametrisation.deviation[:n]
        return bool(np.all(np.abs(self.off) <= MET) and not strange.any())

    @property
    def effects(self) -> tuple[str, ...]:
        return tuple(e.name for e in self.parametrisation.effects)

    @property
    def factors(self) -> Mapping[str, float]:
        """Of the nuisance parameters, on the rig file's values."""
        return {n.name: float(np.exp(v)) for n, v in zip(self.parametrisation.nuisances, self.u, strict=False)}

    def model(self) -> RigModel:
        return self.parametrisation.model(self.u)


@dataclass(frozen=True, eq=False)
class Explanations:
    """as_given: nothing changed; single: each nuisance parameter alone, without prior: how far it would have to go
    calibrated: all nuisance parameters with their priors
    alone, helped: effect -> fit without and with the nuisance parameters; pairs: of two effects without
    still: effects that do not move a stated value; without_place: effect -> why the model cannot take it
    """

    as_given: Explanation
    single: tuple[Explanation, ...]
    calibrated: Explanation
    alone: Mapping[str, Explanation]
    helped: Mapping[str, Explanation]
    pairs: tuple[Explanation, ...]
    still: tuple[str, ...]
    without_place: Mapping[str, str]


def explanations(
    problem: LowForceProblem, effects: Sequence[Effect], progress: Progress = lambda _: None
) -> Explanations:
    """Every explanation by one nuisance parameter, one effect, or two effects."""
    progress("nuisance parameters")
    moving = [n for n in (*nuisances(problem.base), CONTACT) if _moves(problem, n)]
    known = [n for n in moving if n is not CONTACT]
    as_given = explained(problem, "as given", problem.parametrisation(()), [])
    single = tuple(_searched(problem, n.name, (n,)) for n in moving)
    calibrated = _searched(problem, "calibration", known)
    still, without_place, alone, helped = [], {}, {}, {}
    for effect in effects:
        progress(effect.name)
        try:
            moves = _effect_moves(problem, effect)
        except (ValueError, KeyError) as error:
            without_place[effect.name] = str(error.args[0])
            continue
        if not moves:
            still.append(effect.name)
            continue
        alone[effect.name] = _searched(problem, effect.name, (), (effect,))
        helped[effect.name] = _searched(problem, f"{effect.name} and calibration", known, (effect,))
    pairs = _pairs(problem, [e for e in effects if e.name in alone], alone, progress)
    return Explanations(as_given, single, calibrated, alone, helped, pairs, tuple(still), without_place)


def _searched(
    problem: LowForceProblem, name: str, chosen: Sequence[Nuisance], effects: Sequence[Effect] = ()
) -> Explanation:
    return explained(problem, name, problem.parametrisation(chosen, effects), _grid(problem, chosen, effects))


def _pairs(
    problem: LowForceProblem, effects: Sequence[Effect], alone: Mapping[str, Explanation], progress: Progress
) -> tuple[Explanation, ...]:
    """Every two effects together; alone: effect -> its fit without the other"""
    found = []
    for two in combinations(effects, 2):
        name = " and ".join(e.name for e in two)
        progress(name)
        found.append(explained(problem, name, problem.parametrisation((), two), _pair_grid(problem, alone, two)))
    return tuple(found)


def explained(
    problem: LowForceProblem, name: str, parametrisation: Parametrisation, grid: Sequence[Floats]
) -> Explanation:
    """Least squares within the bounds from the best points of the grid."""
    if not len(parametrisation):
        return _explanation(problem, name, parametrisation, np.zeros(0))
    lower, upper = parametrisation.lower, parametrisation.upper

    def residual(u: Floats) -> Floats:
        return residual_of(problem, parametrisation, u)

    def jacobian(u: Floats) -> Floats:
        return _jacobian(residual, u, lower, upper)

    tried = sorted(((float(np.sum(residual(u) ** 2)), i) for i, u in enumerate(grid)))[:_STARTS]
    best, least = grid[tried[0][1]], tried[0][0]
    for _, i in tried:
        start = np.clip(grid[i], lower + 1e-9 * (upper - lower), upper - 1e-9 * (upper - lower))
        found = least_squares(residual, start, jacobian, (lower, upper), x_scale="jac", max_nfev=40)
        if 2 * found.cost < least:
            best, least = found.x, 2 * float(found.cost)
    # contacts open one after the other, and the search ends at the edge of a step: take the smallest effect as good
    level = [v for v in _one_moved(parametrisation, best) if np.sum(residual(v) ** 2) <= least + _LEVEL]
    return _explanation(problem, name, parametrisation, min(level, key=lambda v: float(np.sum(v**2)), default=best))


def _explanation(problem: LowForceProblem, name: str, parametrisation: Parametrisation, u: Floats) -> Explanation:
    frequencies = problem.frequencies(parametrisation.model(u))
    off = (frequencies - problem.stated) / problem.deviation
    residual = residual_of(problem, parametrisation, u)
    J = _jacobian(lambda v: residual_of(problem, parametrisation, v), u, parametrisation.lower, parametrisation.upper)
    # what the values do not determine is free within its bounds
    loose = np.diag((parametrisation.upper - parametrisation.lower) ** -2.0)
    covariance, chi2 = np.asarray(np.linalg.inv(J.T @ J + loose)), float(residual @ residual)
    other = tuple(
        v for v in _one_moved(parametrisation, u)
        if np.sum(residual_of(problem, parametrisation, v) ** 2) <= chi2 + _AS_GOOD
    )  # fmt: skip
    return Explanation(name, parametrisation, u, covariance, frequencies, off, chi2, other)


def _one_moved(parametrisation: Parametrisation, u: Floats) -> list[Floats]:
    """Each parameter of an effect over its bounds, the others held."""
    points = []
    for i in range(len(parametrisation.nuisances), len(u)):
        for bound, share in product((parametrisation.lower[i], parametrisation.upper[i]), _SHARES):
            if bound != 0:
                points.append(u.copy())
                points[-1][i] = share * bound
    return points


def residual_of(problem: LowForceProblem, parametrisation: Parametrisation, u: Floats) -> Floats:
    """Stated values, then priors: those of one nuisance parameter alone are left out, to see how far it would go."""
    off = (problem.frequencies(parametrisation.model(u)) - problem.stated) / problem.deviation
    n = len(parametrisation.nuisances)
    return np.concatenate([off, u[:n] / parametrisation.deviation[:n]]) if _has_prior(parametrisation) else off


def _has_prior(parametrisation: Parametrisation) -> bool:
    return len(parametrisation.nuisances) > 1


def _jacobian(residual: Callable[[Floats], Floats], u: Floats, lower: Floats, upper: Floats) -> Floats:
    """Central differences, to one side at a bound."""
    columns = []
    for i in range(len(u)):
        step = _STEP * max(1.0, abs(u[i]))
        above, below = u.copy(), u.copy()
        above[i], below[i] = min(u[i] + step, upper[i]), max(u[i] - step, lower[i])
        columns.append((residual(above) - residual(below)) / (above[i] - below[i]))
    return np.stack(columns, axis=1) if columns else np.zeros((len(residual(u)), 0))


def _moves(problem: LowForceProblem, nuisance: Nuisance) -> bool:
    plain = problem.frequencies(problem.parametrisation(()).model(np.zeros(0)))
    parametrisation = problem.parametrisation((nuisance,))
    changed = problem.frequencies(parametrisation.model(np.array([nuisance.deviation])))
    return bool(np.any(np.abs(changed / plain - 1) > _MOVES))


def _effect_moves(problem: LowForceProblem, effect: Effect) -> bool:
    parametrisation = problem.parametrisation((), (effect,))
    grid = _grid(problem, (), (effect,))
    frequencies = np.array([problem.frequencies(parametrisation.model(u)) for u in grid])
    return bool(np.any(np.abs(frequencies / frequencies[0] - 1) > _MOVES))


def _grid(problem: LowForceProblem, chosen: Sequence[Nuisance], effects: Sequence[Effect]) -> list[Floats]:
    """The null values, then each parameter moved alone."""
    parametrisation = problem.parametrisation(chosen, effects)
    null = np.zeros(len(parametrisation))
    points = [null]
    for i, bounds in enumerate(zip(parametrisation.lower, parametrisation.upper, strict=True)):
        for bound, share in product(bounds, _SHARES):
            if bound != 0:
                points.append(null.copy())
                points[-1][i] = share * bound
    return points


def _pair_grid(problem: LowForceProblem, alone: Mapping[str, Explanation], two: Sequence[Effect]) -> list[Floats]:
    """Each effect as it does best alone with the other moved, and both at some places."""
    first, second = (alone[e.name].u for e in two)
    of_first, of_second = (_grid(problem, (), (e,)) for e in two)
    points = [np.concatenate([first, v]) for v in of_second] + [np.concatenate([u, second]) for u in of_first]
    return [*points, *(np.concatenate([u, v]) for u, v in product(of_first[1::3], of_second[1::3]))]
