"""Friction that varies over the face."""

from updamp.effects.contact_faces import entry, patches_of, up_the_face
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    """mu (1 + g s), s up the face."""
    s = up_the_face(patches_of(model))
    return model.with_contacts(mu=entry(model, "mu") * (1 + values["gradient"] * s))


EFFECT = Effect(
    "friction_gradient",
    "friction differs between the upper and the lower edge of the faces, as where one of them has worn",
    (EffectParameter("gradient", 0.0, -0.95, 0.95, 0.4, "", "assumed: worn and unworn steel, 0.4 to 0.8"),),
    apply,
)
