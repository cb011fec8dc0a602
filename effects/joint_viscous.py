"""Viscous loss in a joint."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import joint_model, joint_of
from updamp.hbm.problem.structural_changes import Attachment


def apply(model: RigModel, values: Values) -> RigModel:
    """A dashpot to the ground at the joint."""
    if (dashpot := values["dashpot"]) == 0:
        return joint_model(model)
    loss = Attachment("joint's dashpot", {joint_of(model): 1.0}, dashpot=dashpot)
    return replace(model, attachments=(*model.attachments, loss))


EFFECT = Effect(
    "joint_viscous",
    "the joint loses energy in proportion to its velocity, as a film of oil does, whatever the amplitude",
    (
        EffectParameter(
            "dashpot", 0.0, 0.0, 1e3, 2.0, "N*s/m",
            "a damping ratio of 0.1 % of a mode of 2 kg at 80 Hz, as an oiled joint adds", grows_with=(1, 0, -1),
        ),
    ),
    apply,
)  # fmt: skip
