"""A delay of the response: a lag that grows with the frequency, which modes far from each other tell from one that does
not."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    return replace(model, reading=replace(model.reading, delay=model.reading.delay + values["time"]))


EFFECT = Effect(
    "sensor_delay",
    "every response comes late by the same time, and lags by more the higher the frequency is",
    (
        EffectParameter(
            "time", 0.0, -3e-3, 3e-3, 2e-4, "s", "0.1 rad at 80 Hz: some samples, or a filter", grows_with=(0, 0, -1)
        ),
    ),
    apply,
    of_measurement=True,
    modes=2,
)
