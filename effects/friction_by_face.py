"""Friction that differs between the faces."""

import numpy as np

from updamp.effects.contact_faces import entry, patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.geometry.contact_elements import LEFT


def apply(model: RigModel, values: Values) -> RigModel:
    """Left mu (1 - d), right mu (1 + d); the preload stays."""
    sign = np.where(patches_of(model).face == LEFT, -1.0, 1.0)
    return model.with_contacts(mu=entry(model, "mu") * (1 + sign * values["difference"]))


EFFECT = Effect(
    "friction_by_face",
    "friction differs between the two faces of the damper, as where one of them has worn or is oily",
    (EffectParameter("difference", 0.0, -0.95, 0.95, 0.3, "", "assumed: worn and unworn steel, 0.4 to 0.8"),),
    apply,
)
