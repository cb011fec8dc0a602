"""A background in proportion to the force: drive that leaks into the sensor's channel, or modes far away."""

from dataclasses import replace

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel

_SOURCE = "a tenth of the peak of a mode of 1e6 N/m with a loss factor of 1 %"


def apply(model: RigModel, values: Values) -> RigModel:
    """As a displacement; over the few per cent of a sweep round one resonance a velocity is the same."""
    added = model.reading.background + complex(values["in_phase"], values["in_quadrature"])
    return replace(model, reading=replace(model.reading, background=added))


EFFECT = Effect(
    "feed_through",
    "a background in proportion to the force lies under the response",
    (
        EffectParameter("in_phase", 0.0, -1e-3, 1e-3, 1e-5, "m/N", _SOURCE, grows_with=(-1, 0, 0)),
        EffectParameter("in_quadrature", 0.0, -1e-3, 1e-3, 1e-5, "m/N", _SOURCE, grows_with=(-1, 0, 0)),
    ),
    apply,
    of_measurement=True,
)
