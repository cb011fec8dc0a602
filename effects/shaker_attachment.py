"""What the shaker adds to the blade."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.structural_changes import Attachment


def apply(model: RigModel, values: Values) -> RigModel:
    """Mass, spring and dashpot to the ground at the excitation point."""
    mass, stiffness, dashpot = values["mass"], values["stiffness"], values["dashpot"]
    if mass == stiffness == dashpot == 0:
        return model
    shaker = Attachment("shaker", {model.excitation: 1.0}, stiffness, dashpot, mass)
    return replace(model, attachments=(*model.attachments, shaker))


EFFECT = Effect(
    "shaker_attachment",
    "the shaker's armature, stinger and force cell add mass, stiffness and damping where they hold the structure",
    (
        EffectParameter("mass", 0.0, 0.0, 1.0, 0.05, "kg", "force cell and stinger 20-50 g; armatures up to 0.5 kg"),
        EffectParameter(
            "stiffness", 0.0, 0.0, 2e6, 1e5, "N/m", "armature flexures 1e4 N/m; an offset stinger an order more"
        ),
        EffectParameter("dashpot", 0.0, 0.0, 1000.0, 20.0, "N*s/m", "electromagnetic damping of small shakers"),
    ),
    apply,
)
