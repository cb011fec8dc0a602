"""Sensors, or their amplifiers, that are driven beyond the range in which they are linear."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    """To first order in the share that is lost: what a sensor does beyond is its own."""
    added = model.reading.compression + values["per_square"]
    return replace(model, reading=replace(model.reading, compression=added))


EFFECT = Effect(
    "sensor_compression",
    "readings fall short by more the larger the motion is, as of a sensor or an amplifier beyond its range",
    (
        EffectParameter(
            "per_square", 0.0, -1e8, 1e8, 5e6, "1/m^2",
            "of the amplitude's logarithm: 5 % at 0.1 mm; sensors are linear to 1 % of their range",
            grows_with=(0, -2, 0),
        ),
    ),
    apply,
    of_measurement=True,
)  # fmt: skip
