"""A phase that a filter, a delay or a sampling order adds to the response, the same at all frequencies of a sweep."""

from dataclasses import replace

import numpy as np

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    return replace(model, reading=model.reading.turned(complex(np.exp(-1j * values["angle"]))))


EFFECT = Effect(
    "phase_lag",
    "every response lags by the same angle",
    (
        EffectParameter(
            "angle", 0.0, -1.5, 1.5, 0.1, "rad", "a delay of 0.2 ms at 80 Hz, as a filter or a multiplexer has"
        ),
    ),
    apply,
    of_measurement=True,
)
