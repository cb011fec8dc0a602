"""Dry friction at the blades' tips, as of a cable that rubs."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.dry_friction import DryFriction

# m/s: a hundredth of what tips reach at resonance. Below it something soft, as a cable, gives way rather than slides.
CREEP = 5e-4


def apply(model: RigModel, values: Values) -> RigModel:
    """F tanh(v / creep) at each tip; at 0 too, so that models of all values have the same unknowns."""
    return with_tip_elements(model, "dry friction", DryFriction(CREEP), force=(values["left"], values["right"]))


EFFECT = Effect(
    "tip_friction",
    "dry friction at the tips, as of a cable that rubs: a loss that counts less the larger the amplitude",
    (
        EffectParameter("left", 0.0, 0.0, 1.0, 0.01, "N", "assumed: a cable of some grams that lies on the blade"),
        EffectParameter("right", 0.0, 0.0, 1.0, 0.01, "N", "as the left one"),
    ),
    apply,
)
