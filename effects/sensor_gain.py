"""A wrong calibration factor, common to all sensors, or sensors that look at another height than stated, which is the
same in modes of one shape there. It shows where masses follow from dimensions: of modes that were identified in a test
the masses are as unsure, and take it up."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    return replace(model, reading=model.reading.turned(1 + values["gain"]))


EFFECT = Effect(
    "sensor_gain",
    "every sensor reads too much, or too little, by the same factor: its calibration, or where it looks",
    (EffectParameter("gain", 0.0, -0.5, 0.5, 0.05, "", "half a decibel"),),
    apply,
    of_measurement=True,
)
