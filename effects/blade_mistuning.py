"""Blades that are not alike."""

from dataclasses import replace

import numpy as np

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import modes_of


def apply(model: RigModel, values: Values) -> RigModel:
    """Natural frequencies of the right blade times 1 + d/2, of the left one times 1 - d/2; loss factors stay.

    Mode shapes and residual flexibility stay too: a difference of stiffness would change the latter by d, which is
    d times its share of the contacts' flexibility.
    """
    c, factor = model.components, np.ones(len(model.owner))
    for blade, sign in (("blade_left", -1.0), ("blade_right", 1.0)):
        factor[modes_of(model, blade)] = 1 + sign * values["difference"] / 2
    scaled = np.outer(factor, factor)
    changed = replace(
        c,
        omega_squared=c.omega_squared * factor**2,
        hysteretic=c.hysteretic * scaled,
        viscous=c.viscous * np.sqrt(scaled),
    )
    return replace(model, components=changed)


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
