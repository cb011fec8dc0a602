"""The parameters of a fit: nuisance parameters, which every comparison has to settle first, and those of effects."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.chosen import ChosenEffect, with_effects
from updamp.diagnosis.effects.effect import Effect
from updamp.diagnosis.model.numerical_error import NumericalError
from updamp.diagnosis.model.rig_model import RigModel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Nuisance:
    """A factor on a quantity that is known only roughly, and that differs a little from one assembly to the next.

    The fit sees its logarithm, which is normally distributed about 0.

    deviation: prior standard deviation of the logarithm; largest: bound on its size
    scatter: what its logarithm is expected to vary by from one assembly to the next (standard deviation), before the
        repeats have been looked at
    apply(model, factor) -> model
    """

    name: str
    sentence: str
    deviation: float
    largest: float
    scatter: float
    apply: Callable[[RigModel, float], RigModel]


def _stiffness_of_material(model: RigModel, factor: float) -> RigModel:
    c = model.components
    changed = replace(
        c, omega_squared=c.omega_squared * factor, residual=c.residual / factor, hysteretic=c.hysteretic * factor
    )
    return replace(model, components=changed)


def _loss_factor(model: RigModel, factor: float) -> RigModel:
    c = model.components
    return replace(model, components=replace(c, hysteretic=c.hysteretic * factor, viscous=c.viscous * factor))


def _modal_mass(model: RigModel, factor: float) -> RigModel:
    """Frequencies and loss factors stay."""
    c = model.components
    return replace(model, components=replace(c, phi=c.phi / np.sqrt(factor), residual=c.residual / factor))


@dataclass(frozen=True)
class _ContactEntry:
    """A factor on one entry of the contacts' parameters."""

    entry: str

    def __call__(self, model: RigModel, factor: float) -> RigModel:
        assert model.contacts is not None, "asked for where there are contacts only"
        return model.with_contacts(**{self.entry: getattr(model.contacts.parameters, self.entry) * factor})


YOUNGS_MODULUS = Nuisance(
    "youngs_modulus", "Young's modulus of blades and damper", 0.01, 0.05, 2e-4, _stiffness_of_material
)
LOSS_FACTOR = Nuisance("loss_factor", "material loss factor", 0.5, 1.5, 0.02, _loss_factor)
FRICTION = Nuisance("friction_coefficient", "friction coefficient", 0.3, 1.5, 0.05, _ContactEntry("mu"))
TANGENTIAL = Nuisance("tangential_stiffness", "tangential contact stiffness", 0.7, 2.5, 0.05, _ContactEntry("kt"))
NORMAL = Nuisance("normal_stiffness", "normal contact stiffness", 0.7, 2.5, 0.05, _ContactEntry("kn"))
PRELOAD = Nuisance("preload", "preload of the contacts", 0.02, 0.1, 0.03, _ContactEntry("n0"))
# Of modes identified in a test, whose frequencies are known best and whose masses least (half a decibel).
MODAL_STIFFNESS = Nuisance("modal_stiffness", "modal stiffness", 0.01, 0.05, 2e-4, _stiffness_of_material)
MODAL_MASS = Nuisance("modal_mass", "modal mass", 0.05, 0.5, 0.01, _modal_mass)


OF_STRUCTURE, OF_CONTACTS = (YOUNGS_MODULUS, LOSS_FACTOR), (FRICTION, TANGENTIAL, NORMAL, PRELOAD)
OF_RIG, OF_MODES = (*OF_STRUCTURE, *OF_CONTACTS), (MODAL_STIFFNESS, LOSS_FACTOR, MODAL_MASS)


def nuisances(model: RigModel) -> tuple[Nuisance, ...]:
    """Those that the model has a place for."""
    if model.identified:
        return OF_MODES
    return OF_RIG if model.contacts else OF_STRUCTURE


# Bound on the size of a numerical error, in units of the difference that finer numerics make.
_MOST = 4.0


@dataclass(frozen=True, eq=False)
class Parametrisation:
    """A base model with what may change in it. The vector u has one entry a nuisance (logarithm of its factor), then
    one for each parameter of each effect, scaled: 0 at its null value, 1 at its typical one; then one for each pattern
    of numerical error, which does not change the model but what is observed of it.

    taken: effects with fixed values, those of the rig file; `base` is the model before them. They are applied after the
        nuisance parameters, as all effects are, so that a fit finds the same whether an effect's values are free or
        have been taken up.
    """

    base: RigModel
    nuisances: tuple[Nuisance, ...]
    effects: tuple[Effect, ...] = ()
    numerics: NumericalError = field(default_factory=NumericalError)
    taken: tuple[ChosenEffect, ...] = ()

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
        of_effects = [min(b) for b in self._effect_bounds()]
        return np.array([-n.largest for n in self.nuisances] + of_effects + [-_MOST] * len(self.numerics.names))

    @property
    def upper(self) -> Floats:
        of_effects = [max(b) for b in self._effect_bounds()]
        return np.array([n.largest for n in self.nuisances] + of_effects + [_MOST] * len(self.numerics.names))

    @property
    def deviation(self) -> Floats:
        """Prior standard deviations; effects have none (infinite)."""
        of_effects = [np.inf] * (self.n_of_model - len(self.nuisances))
        return np.array([n.deviation for n in self.nuisances] + of_effects + [1.0] * len(self.numerics.names))

    def _effect_bounds(self) -> list[tuple[float, float]]:
        return [
            ((p.lower - p.null) / (p.typical - p.null), (p.upper - p.null) / (p.typical - p.null))
            for e in self.effects
            for p in e.parameters
        ]

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
        model = with_effects(model, self.taken)
        values = self.values(u)
        for effect in self.effects:
            model = effect.apply(model, values[effect.name])
        return model
