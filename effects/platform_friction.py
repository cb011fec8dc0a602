"""Dry friction between the two platforms."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_platform_element
from updamp.hbm.contact.dry_friction import DryFriction

# m/s: a hundredth of what platforms reach against each other.
CREEP = 5e-5


def apply(model: RigModel, values: Values) -> RigModel:
    """F tanh(v / creep), v of one platform against the other; at 0 too, so that models of all values have the same
    unknowns."""
    return with_platform_element(model, "dry friction across the gap", DryFriction(CREEP), force=values["force"])


EFFECT = Effect(
    "platform_friction",
    "the platforms rub across their gap: a loss out of phase that counts less the larger the amplitude",
    (
        EffectParameter(
            "force", 0.0, 0.0, 20.0, 0.1, "N", "assumed: a seal strip or debris in the gap, pressed by less than 1 N"
        ),
    ),
    apply,
)
