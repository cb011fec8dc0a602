"""Viscous loss in a joint."""

from dataclasses import replace

from updamp.diagnosis.effects.effect import Effect, EffectParameter, Values
from updamp.diagnosis.effects.joint import checked
from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.structural_changes import Attachment


def apply(model: RigModel, values: Values) -> RigModel:
    """A dashpot to the ground at the excitation point."""
    if (dashpot := values["dashpot"]) == 0:
        return checked(model)
    loss = Attachment("joint's dashpot", {checked(model).excitation: 1.0}, dashpot=dashpot)
    return replace(model, attachments=(*model.attachments, loss))


EFFECT = Effect(
    "joint_viscous",
    "the joint loses energy in proportion to its velocity, as a film of oil does, whatever the amplitude",
    (
        EffectParameter(
            "dashpot", 0.0, 0.0, 1e3, 2.0, "N*s/m",
            "a damping ratio of 0.1 % of a mode of 2 kg at 80 Hz, as an oiled joint adds",
        ),
    ),
    apply,
)  # fmt: skip
