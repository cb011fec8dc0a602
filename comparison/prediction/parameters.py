"""The parameters of a fit: nuisance parameters, which every comparison has to settle first, and those of effects."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.effects.chosen import ChosenEffect, with_effects
from updamp.effects.effect import Effect
from updamp.effects.rig_model import RigModel
from updamp.model.calibration import Nuisance

Floats = NDArray[np.float64]


# Bound on the size of a numerical error, in units of the difference that finer numerics make.
_MOST = 4.0
# Least size, in typical ones, that an effect is fitted with which has no derivative at its null value.
_LEAST = 1e-3


@dataclass(frozen=True, eq=False)
class Parametrisation:
    """A base model with what may change in it. The vector u has one entry a nuisance (logarithm of its factor), then
    one for each parameter of each effect, scaled: 0 at its null value, 1 at its typical one; then one for each pattern
    of numerical error, which does not change the model but what is observed of it.

    rig_effects: effects of the rig file, with the values stated there; `base` is the model before them. They are
        applied after the nuisance parameters, as all effects are, so that a fit finds the same whether an effect's
        values are free or stated.
    """

    base: RigModel
    nuisances: tuple[Nuisance, ...]
    effects: tuple[Effect, ...] = ()
    numerics: NumericalError = field(default_factory=NumericalError)
    rig_effects: tuple[ChosenEffect, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        of_effects = (f"{e.name}.{p.name}" for e in self.effects for p in e.parameters)
        return (*(n.name for n in self.nuisances), *of_effects, *(f"numerics.{n}" for n in self.numerics.names))

    def __len__(self) -> int:
        return len(self.names)

    @property
    def n_of_model(self) -> int:
        """How many change the model itself: the first ones."""
        return len(self) - len(self.numerics.names)

    @property
    def lower(self) -> Floats:
        of_effects = [lower for lower, _ in self._effect_bounds()]
        return np.array([-n.largest for n in self.nuisances] + of_effects + [-_MOST] * len(self.numerics.names))

    @property
    def upper(self) -> Floats:
        of_effects = [upper for _, upper in self._effect_bounds()]
        return np.array([n.largest for n in self.nuisances] + of_effects + [_MOST] * len(self.numerics.names))

    @property
    def deviation(self) -> Floats:
        """Prior standard deviations; effects have none (infinite)."""
        of_effects = [np.inf] * (self.n_of_model - len(self.nuisances))
        return np.array([n.deviation for n in self.nuisances] + of_effects + [1.0] * len(self.numerics.names))

    def _effect_bounds(self) -> list[tuple[float, float]]:
        """Null values at a bound are left out where there is no derivative to leave them by: a fit would stay there."""
        found = []
        for e in self.effects:
            for p in e.parameters:
                ends = ((p.lower - p.null) / (p.typical - p.null), (p.upper - p.null) / (p.typical - p.null))
                absent = _LEAST if e.finite_step and 0.0 in ends else 0.0
                found.append((min(ends) or absent, max(ends) or 0.0 - absent))
        return found

    @cached_property
    def mirrored(self) -> bool:
        """Whether the model is its own mirror image whatever its parameters are: with all effects at their typical
        values it is. No nuisance tells one side of a rig from its image."""
        return is_driven_symmetrically(self._with_typical_effects)

    @cached_property
    def runs_in(self) -> bool:
        """Whether it may be another model from run to run."""
        return self._with_typical_effects.running_in != 0

    @cached_property
    def _with_typical_effects(self) -> RigModel:
        u = np.zeros(len(self))
        u[len(self.nuisances) : self.n_of_model] = 1.0
        return self.model(u)

    def columns(self, effect: str) -> slice:
        """Where the parameters of one of the effects stand in u.

        raises: KeyError for an effect that it does not have
        """
        place = len(self.nuisances)
        for other in self.effects:
            n = len(other.parameters)
            if other.name == effect:
                return slice(place, place + n)
            place += n
        raise KeyError(effect)

    def with_further(self, u: Floats, values: Floats) -> Floats:
        """u with those of further effects after its own: before the patterns of numerical error."""
        return np.concatenate([u[: self.n_of_model], values, u[self.n_of_model :]])

    def before_calibration(self, u: Floats) -> Floats:
        """(p,) with nuisance parameters and numerical error back at what they were before calibration; effects as at u,
        which may have another numerical error. A calibration to data with something else in them leads astray."""
        found, effects = np.zeros(len(self)), slice(len(self.nuisances), self.n_of_model)
        found[effects] = u[effects]
        return found

    def values(self, u: Floats) -> dict[str, dict[str, float]]:
        """Effect -> parameter -> value at u, in the parameter's own unit."""
        values: dict[str, dict[str, float]] = {}
        place = len(self.nuisances)
        for effect in self.effects:
            values[effect.name] = {}
            for p in effect.parameters:
                values[effect.name][p.name] = float(p.null + u[place] * (p.typical - p.null))
                place += 1
        return values

    def model(self, u: Floats) -> RigModel:
        model = self.base
        for nuisance, log_factor in zip(self.nuisances, u, strict=False):
            if log_factor != 0:
                model = nuisance.apply(model, float(np.exp(log_factor)))
        model = with_effects(model, self.rig_effects)
        values = self.values(u)
        for effect in self.effects:
            model = effect.apply(model, values[effect.name])
        return model


def is_driven_symmetrically(model: RigModel) -> bool:
    """Whether a model and its excitation are their own mirror image (hbm/problem/mirror.py)."""
    system = model.system
    return system.half_driven_at(system.free.row(model.excitation)) is not None
