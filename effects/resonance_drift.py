"""Resonances that fall, or rise, while a sweep lasts, as those of a structure that warms up."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    return replace(model, reading=replace(model.reading, drift=model.reading.drift + values["growth"]))


EFFECT = Effect(
    "resonance_drift",
    "resonances fall, or rise, from the start of each sweep to its end, as of a structure that warms up",
    (
        EffectParameter(
            "growth", 0.0, -0.05, 0.05, 5e-4, "", "of the frequency's logarithm: steel that warms up by 3 K in a sweep"
        ),
    ),
    apply,
    of_measurement=True,
)
