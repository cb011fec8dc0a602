"""The damper's mean motion."""

from dataclasses import replace

from updamp.effects.contact_faces import modify_contacts
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.modified.static_share import StaticShare
from updamp.hbm.harmonics import Harmonics


def apply(model: RigModel, values: Values) -> RigModel:
    """At c > 0 the zero harmonic joins, of which the contacts see the share c.

    raises: ValueError where the model has the zero harmonic without the effect
    """
    share = values["share"]
    if share == 0:
        return model
    if 0 in model.harmonics.orders:
        raise ValueError(
            "the model has the zero harmonic already, so its contacts see the mean motion: take 0 out of "
            "harmonic_balance.harmonics, or the effect static_dynamic_coupling out of the rig file"
        )
    model = replace(model, harmonics=Harmonics((0, *model.harmonics.orders)))
    return modify_contacts(model, StaticShare, static_share=share) if share != 1 else model


EFFECT = Effect(
    "static_dynamic_coupling",
    "vibration shifts the damper's mean position, and with it the contacts' preload (zero harmonic)",
    (
        EffectParameter(
            "share", 0.0, 0.0, 1.0, 0.2, "",
            "1 is what mechanics asks for; less where something holds the damper", (1.0,),
        ),
    ),
    apply,
    # The wires are so soft against the contacts that a share of a millionth is felt already: no derivative at 0 tells
    # anything about 1.
    finite_step=True,
)  # fmt: skip
