"""The model at one place in the space of its parameters, and how it changes around there."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.derivatives import Change
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.linear_model import LinearModel
from updamp.hbm.system import NonlinearSystem

Floats = NDArray[np.float64]

_STEP = 1e-5  # of a parameter, for differences to one side


@dataclass(frozen=True, eq=False)
class ModelAt:
    """u: (p,) parameters; what is made of them is made once for all branches."""

    parametrisation: Parametrisation
    u: Floats

    @cached_property
    def model(self) -> RigModel:
        return self.parametrisation.model(self.u)

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """A difference for every parameter of the model, upwards unless a bound is near."""
        found = []
        for j in range(self.parametrisation.n_of_model):
            step = _STEP if self.u[j] + _STEP <= self.parametrisation.upper[j] else -_STEP
            there = self.u.copy()
            there[j] += step
            found.append(change_to(self.model, self.parametrisation.model(there), step))
        return tuple(found)


def change_to(model: RigModel, changed: RigModel, step: float) -> Change:
    """step: of the parameter between the two"""
    if not _same_structure(model, changed):
        return Change(changed.system, step, contacts_alone=False)
    # the same object: what was worked out for it holds
    system = NonlinearSystem(model.system.free, changed.groups, changed.harmonics, changed.time_samples)
    return Change(system, step, contacts_alone=True)


def _same_structure(a: RigModel, b: RigModel) -> bool:
    points = [e.point for e in a.elements] == [e.point for e in b.elements]
    same = points and a.harmonics == b.harmonics and a.attachments == b.attachments
    return same and _equal(a.components, b.components)


def _equal(a: LinearModel, b: LinearModel) -> bool:
    arrays = ("omega_squared", "phi", "residual", "hysteretic", "viscous")
    return a is b or all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
