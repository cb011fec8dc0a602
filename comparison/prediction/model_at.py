"""The model at one place in the space of its parameters, and how it changes around there."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.derivatives import Change
from updamp.comparison.prediction.parameters import Parametrisation, is_driven_symmetrically
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.mirror import Mirror, half_groups, half_structure
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]

_STEP = 1e-5  # of a parameter
_STEP_OF_EFFECT = 1e-3  # likewise, of its typical size


@dataclass(frozen=True, eq=False)
class ModelAt:
    """u: (p,) parameters; what is made of them is made once for all branches of one place.

    place: of the test among the runs of an assembly, as `RunCondition.place`
    """

    parametrisation: Parametrisation
    u: Floats
    place: float = 0.0

    @cached_property
    def model(self) -> RigModel:
        return self.parametrisation.model(self.u).in_run(self.place)

    @cached_property
    def mirror(self) -> Mirror | None:
        """Of which half is solved; None where the whole is."""
        return self.model.system.mirror if self.parametrisation.mirrored else None

    @cached_property
    def system(self) -> NonlinearSystem:
        """What is solved: the half of a model that is its own mirror image whatever its parameters are."""
        return self.model.system if self.mirror is None else self.model.system.halved(self.mirror)

    def at(self, condition: RunCondition) -> "ModelAt":
        """As it was in a test."""
        return replace(self, place=condition.place) if self.parametrisation.runs_in else self

    def excited_by(self, force: float) -> Excitation:
        """force: amplitude [N]"""
        return Excitation(self.system.free.row(self.model.excitation), force)

    def whole(self, x: Floats) -> Floats:
        """Relative displacements (n_relative, n_coefficients) of the whole model from what was solved."""
        return x if self.mirror is None else self.mirror.whole(x)

    def solved(self, x: Floats) -> Floats:
        """What is solved of relative displacements (..., n_relative, n_coefficients) of the whole model."""
        return x if self.mirror is None else self.mirror.halved(x)

    def keeps_symmetry(self, changed: RigModel) -> bool:
        """Whether a changed model can be solved as this one is."""
        return self.mirror is None or is_driven_symmetrically(changed)

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """A difference for every parameter of the model: for contacts, whose forces have kinks, upwards unless a bound
        is near; for the structure to both sides unless a bound is."""
        found = []
        for j in range(self.parametrisation.n_of_model):
            step = _STEP if self.u[j] + _STEP <= self.parametrisation.upper[j] else -_STEP
            change = change_to(self, self._moved(j, step), step)
            if not change.contacts_alone and self.u[j] - _STEP >= self.parametrisation.lower[j] and step > 0:
                change = replace(change, opposite=_system_of(self, self._moved(j, -step)))
            found.append(change)
        return tuple(found)

    def _moved(self, which: int, step: float) -> RigModel:
        there = self.u.copy()
        there[which] += step
        return self.parametrisation.model(there).in_run(self.place)


def model_at(parametrisation: Parametrisation, u: Floats, condition: RunCondition) -> ModelAt:
    """As it was in a test: the same one as before where nothing else was asked for meanwhile. The branches of a plan
    come one after the other, and what is made of the parameters serves all of them that it is the same for."""
    place = condition.place if parametrisation.runs_in else 0.0
    return _cached_model_at(parametrisation, np.asarray(u, dtype=float).tobytes(), place)


@lru_cache(maxsize=1)
def _cached_model_at(parametrisation: Parametrisation, u: bytes, place: float) -> ModelAt:
    return ModelAt(parametrisation, np.frombuffer(u), place)


def change_to(there: ModelAt, changed: RigModel, step: float) -> Change:
    """step: of the parameter between the two; the changed one may have further elements, after those of the model"""
    alone = _same_structure(there.model, changed)
    added = () if alone else added_points(there.model, changed)
    return Change(_system_of(there, changed, alone), step, contacts_alone=alone, added=added, reading=changed.reading)


def added_points(model: RigModel, changed: RigModel) -> tuple[str, ...]:
    """Points of elements that the changed model has after those of the other one, in their order."""
    return tuple(point for e in changed.elements[len(model.elements) :] for point in e.points)


def _system_of(there: ModelAt, changed: RigModel, contacts_alone: bool = False) -> NonlinearSystem:
    """The changed model's, as this one's is solved. What does not change is the same object: what was worked out for it
    holds."""
    free = there.system.free if contacts_alone else _free(there, changed)
    groups = changed.groups if there.mirror is None else half_groups(changed.groups, _mirror_of(changed))
    own = (*there.system.groups, *groups[len(there.system.groups) :])
    kept = tuple(a if _equal_groups(a, b) else b for a, b in zip(own, groups, strict=True))
    return NonlinearSystem(free, kept, changed.harmonics, changed.time_samples, mean_held=True)


def _free(there: ModelAt, changed: RigModel) -> LinearModel:
    return changed.free if there.mirror is None else half_structure(changed.free, _mirror_of(changed))


def _mirror_of(model: RigModel) -> Mirror:
    mirror = model.system.mirror
    assert mirror is not None, "asked for of models that are their own mirror image"
    return mirror


def change_of_effect(there: ModelAt, effect: Effect, parameter: EffectParameter, place: float) -> Change:
    """By one parameter of an effect that the model does not have yet, scaled as in a `Parametrisation`.

    place: of the test among the runs of an assembly, which matters to effects that change from run to run
    """
    step = _STEP_OF_EFFECT
    value = parameter.null + step * (parameter.typical - parameter.null)
    changed = effect.apply(there.model, {**effect.at_null(), parameter.name: value})
    return change_to(there, changed.in_run(place), step)


def _same_structure(a: RigModel, b: RigModel) -> bool:
    points = [e.points for e in a.elements] == [e.points for e in b.elements]
    same = points and a.harmonics == b.harmonics and a.attachments == b.attachments
    return same and _equal(a.components, b.components)


def _equal_groups(a: ElementGroup, b: ElementGroup) -> bool:
    if a is b:
        return True
    same = a.law == b.law and type(a.parameters) is type(b.parameters) and np.array_equal(a.rows, b.rows)
    return same and all(np.array_equal(x, y) for x, y in zip(a.values, b.values, strict=True))


def _equal(a: LinearModel, b: LinearModel) -> bool:
    arrays = ("omega_squared", "phi", "residual", "hysteretic", "viscous")
    return a is b or all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
