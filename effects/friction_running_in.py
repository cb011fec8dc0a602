"""Friction that changes from run to run of an assembly, as faces run in or wear."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    """Friction times exp(growth s) in a run, s from -1/2 in the first of an assembly to 1/2 in the last.

    The model's own is that of the middle of a test (`RigModel.in_run`). An assembly begins anew: its faces meet
    elsewhere.
    """
    if values["growth"] == 0:
        return model
    if model.contacts is None:
        raise ValueError("this model has no contacts whose friction could change")
    return replace(model, running_in=model.running_in + values["growth"])


EFFECT = Effect(
    "friction_running_in",
    "friction grows or falls from run to run of an assembly, as faces run in or wear",
    (
        EffectParameter(
            "growth", 0.0, -1.0, 1.0, 0.2, "",
            "assumed: of the logarithm of friction from the first run to the last, a fifth as faces run in",
        ),
    ),
    apply,
)  # fmt: skip
