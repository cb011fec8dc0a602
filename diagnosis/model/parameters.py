"""The parameters of a fit: nuisance parameters, which every comparison has to settle first, and those of effects."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.effects.effect import Effect
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


def _contact_entry(*entries: str) -> Callable[[RigModel, float], RigModel]:
    def apply(model: RigModel, factor: float) -> RigModel:
        assert model.contacts is not None, "asked for where there are contacts only"
        parameters = model.contacts.parameters
        return model.with_contacts(**{entry: getattr(parameters, entry) * factor for entry in entries})

    return apply


YOUNGS_MODULUS = Nuisance(
    "youngs_modulus", "Young's modulus of blades and damper", 0.01, 0.05, 2e-4, _stiffness_of_material
)
LOSS_FACTOR = Nuisance("loss_factor", "material loss factor", 0.5, 1.5, 0.02, _loss_factor)
FRICTION = Nuisance("friction_coefficient", "friction coefficient", 0.3, 1.5, 0.05, _contact_entry("mu"))
TANGENTIAL = Nuisance("tangential_stiffness", "tangential contact stiffness", 0.7, 2.5, 0.05, _contact_entry("kt"))
NORMAL = Nuisance("normal_stiffness", "normal contact stiffness", 0.7, 2.5, 0.05, _contact_entry("kn"))
PRELOAD = Nuisance("preload", "preload of the contacts", 0.02, 0.1, 0.03, _contact_entry("n0"))


def nuisances(model: RigModel) -> tuple[Nuisance, ...]:
    """Those that the model has a place for."""
    return (YOUNGS_MODULUS, LOSS_FACTOR, *((FRICTION, TANGENTIAL, NORMAL, PRELOAD) if model.contacts else ()))


@dataclass(frozen=True, eq=False)
class Parametrisation:
    """A base model with what may change in it. The vector u has one entry a nuisance (logarithm of its factor), then
    one for each parameter of each effect, scaled: 0 at its null value, 1 at its typical one.
    """

    base: RigModel
    nuisances: tuple[Nuisance, ...]
    effects: tuple[Effect, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        of_effects = (f"{e.name}.{p.name}" for e in self.effects for p in e.parameters)
        return (*(n.name for n in self.nuisances), *of_effects)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def lower(self) -> Floats:
        return np.array([-n.largest for n in self.nuisances] + [min(b) for b in self._effect_bounds()])

    @property
    def upper(self) -> Floats:
        return np.array([n.largest for n in self.nuisances] + [max(b) for b in self._effect_bounds()])

    @property
    def deviation(self) -> Floats:
        """Prior standard deviations; effects have none (infinite)."""
        return np.array([n.deviation for n in self.nuisances] + [np.inf] * (len(self) - len(self.nuisances)))

    def _effect_bounds(self) -> list[tuple[float, float]]:
        return [
            ((p.lower - p.null) / (p.typical - p.null), (p.upper - p.null) / (p.typical - p.null))
            for e in self.effects
            for p in e.parameters
        ]

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
        values = self.values(u)
        for effect in self.effects:
            model = effect.apply(model, values[effect.name])
        return model

    def with_effects(self, effects: Sequence[Effect]) -> "Parametrisation":
        return replace(self, effects=tuple(effects))
