"""A gain that drifts while a sweep lasts, as an amplifier's does that warms up."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    return replace(model, reading=replace(model.reading, trend=model.reading.trend + values["growth"]))


EFFECT = Effect(
    "amplifier_drift",
    "readings grow, or fall, from the start of each sweep to its end",
    (EffectParameter("growth", 0.0, -1.0, 1.0, 0.05, "", "of the amplitude's logarithm: half a decibel a sweep"),),
    apply,
    of_measurement=True,
)
