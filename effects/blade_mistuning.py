"""Blades that are not alike."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import modes_of

Floats = NDArray[np.float64]


def apply(model: RigModel, values: Values) -> RigModel:
    """Natural frequencies of the right blade times 1 + d/2, of the left one times 1 - d/2, as of another modulus of
    elasticity: residual flexibility changes with the square, mode shapes and loss factors stay.
    """
    c, factor = model.components, np.ones(len(model.owner))
    residual = c.residual.copy()
    for blade, sign in (("blade_left", -1.0), ("blade_right", 1.0)):
        of_blade = 1 + sign * values["difference"] / 2
        factor[modes_of(model, blade)] = of_blade
        residual += (of_blade**-2 - 1) * _residual_of(model, blade)
    scaled = np.outer(factor, factor)
    changed = replace(
        c,
        omega_squared=c.omega_squared * factor**2,
        residual=residual,
        hysteretic=c.hysteretic * scaled,
        viscous=c.viscous * np.sqrt(scaled),
    )
    return replace(model, components=changed)


def _residual_of(model: RigModel, blade: str) -> Floats | float:
    """(n_rows, n_rows) [m/N]; 0 where the model has none. As built, times what calibration has made of that of all."""
    as_built = sum(float(np.trace(each)) for each in model.residual_of.values())
    if blade not in model.residual_of or as_built == 0:
        return 0.0
    return float(np.trace(model.components.residual)) / as_built * model.residual_of[blade]


EFFECT = Effect(
    "blade_mistuning",
    "one blade alone vibrates faster than the other",
    (
        EffectParameter(
            "difference", 0.0, -0.05, 0.05, 0.01, "", "0.2-2 % between blades that are machined to be alike"
        ),
    ),
    apply,
)
