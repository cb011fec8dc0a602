"""Crowned faces."""

import numpy as np

from updamp.effects.contact_faces import along_damper, entry, patches_of, with_totals_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    """n0 (1 + c (1/3 - s^2)), s along the damper, each face with the total that it had. At c = 3/2 the ends carry
    nothing, at -3 the middle does not."""
    patches, n0 = patches_of(model), entry(model, "n0")
    crowned = n0 * np.maximum(1 + values["crown"] * (1 / 3 - along_damper(patches) ** 2), 0.0)
    return model.with_contacts(n0=with_totals_of(crowned, n0, patches))


EFFECT = Effect(
    "pressure_crown",
    "the faces are crowned along the damper: the middle carries more load than the ends",
    (
        EffectParameter(
            "crown", 0.0, -3.0, 1.5, 0.8, "",
            "assumed: ends unloaded by half, as crowned or bent dampers show on pressure film",
        ),
    ),
    apply,
)  # fmt: skip
