"""Damping of the blades' tips that sets in above an amplitude."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.threshold_damper import ThresholdDamper


def apply(model: RigModel, values: Values) -> RigModel:
    """c v max(0, 1 - a / |u|) at both tips; at 0 too, so that models of all values have the same unknowns."""
    return with_tip_elements(
        model, "threshold damper", ThresholdDamper(), dashpot=values["dashpot"], threshold=values["threshold"]
    )


EFFECT = Effect(
    "threshold_damping",
    "a loss at the tips sets in above an amplitude, as where something comes loose or into reach",
    (
        EffectParameter(
            "dashpot", 0.0, 0.0, 1e3, 2.0, "N*s/m",
            "assumed: far beyond the threshold as much as a loss factor of half a per cent",
        ),
        EffectParameter(
            "threshold", 5e-6, 1e-8, 1e-3, 1e-5, "m", "assumed: within what the tips of such rigs reach in a test",
            shape=True,
        ),
    ),
    apply,
)  # fmt: skip
