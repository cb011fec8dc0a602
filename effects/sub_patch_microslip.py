"""Microslip inside the contact elements."""

from updamp.effects.contact_faces import modify_contacts
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.modified.microslip import SubPatchMicroslip


def apply(model: RigModel, values: Values) -> RigModel:
    """Parallel sliders with limits spread evenly over mu N (1 - w) ... mu N (1 + w)."""
    return modify_contacts(model, SubPatchMicroslip, limit_spread=values["spread"]) if values["spread"] != 0 else model


EFFECT = Effect(
    "sub_patch_microslip",
    "slip begins in parts of a contact patch before all of it slides",
    (
        EffectParameter(
            "spread", 0.0, 0.0, 1.0, 0.8, "",
            "1 where slip begins with the smallest force (Iwan 1966, uniform limits)", (1.0,),
        ),
    ),
    apply,
    # Weaker and stronger sliders balance to first order: near 0 the response changes with the square of the spread.
    finite_step=True,
)  # fmt: skip
