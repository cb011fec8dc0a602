"""Stiffness of the pulling wires."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.rig.wires import AXIAL


def apply(model: RigModel, values: Values) -> RigModel:
    """A factor on the axial stiffness of both wires. raises: ValueError where the model has no such wires"""
    if values["factor"] != 1 and not any(a.name in AXIAL for a in model.attachments):
        raise ValueError(f"the model has no attachments named {' or '.join(AXIAL)}: leave wire_stiffness out")
    changed = tuple(
        replace(a, stiffness=a.stiffness * values["factor"]) if a.name in AXIAL else a for a in model.attachments
    )
    return replace(model, attachments=changed)


EFFECT = Effect(
    "wire_stiffness",
    "the pulling wires are stiffer or softer along their axis than stated",
    (
        EffectParameter(
            "factor", 1.0, 0.02, 50.0, 5.0, "",
            "wires over pulleys to dead weights: the frame and the pulleys change the stiffness several times over",
        ),
    ),
    apply,
)  # fmt: skip
