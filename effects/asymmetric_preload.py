"""Unequal normal load on both faces."""

import numpy as np

from updamp.effects.contact_faces import entry, patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.geometry.contact_elements import LEFT


def apply(model: RigModel, values: Values) -> RigModel:
    """Left n0 (1 - a), right n0 (1 + a)."""
    sign = np.where(patches_of(model).face == LEFT, -1.0, 1.0)
    return model.with_contacts(n0=entry(model, "n0") * (1 + sign * values["asymmetry"]))


EFFECT = Effect(
    "asymmetric_preload",
    "one face of the damper carries more of the load than the other, as friction at assembly leaves it",
    (
        EffectParameter(
            "asymmetry", 0.0, -0.9, 0.9, 0.2, "",
            "assumed: static friction at 0.6 lets the faces differ by more than this (Pesaresi et al. 2017, eq. 5)",
        ),
    ),
    apply,
)  # fmt: skip
