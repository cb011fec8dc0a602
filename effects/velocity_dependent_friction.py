"""Friction that depends on the sliding speed."""

from updamp.effects.contact_faces import modify_contacts
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction

# m/s: an amplitude of 36 nm at 440 Hz. Contacts of such rigs slip at some tenths of a millimetre a second.
REFERENCE_SPEED = 1e-4


def apply(model: RigModel, values: Values) -> RigModel:
    """mu (1 - d v / (v + v0)), v the tangential relative velocity, v0 = 0.1 mm/s."""
    if values["drop"] == 0:
        return model
    return modify_contacts(model, VelocityFriction, velocity_drop=values["drop"], reference_speed=REFERENCE_SPEED)


EFFECT = Effect(
    "velocity_dependent_friction",
    "the friction coefficient falls with the sliding speed",
    (
        EffectParameter(
            "drop", 0.0, -0.5, 0.9, 0.3, "", "dry steel: kinetic friction 20-40 % below static friction (Stribeck 1902)"
        ),
    ),
    apply,
)
