"""Dry friction beside the motion: at a clamp, a guide or a cable that slides all the time."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.coulomb_friction import CoulombFriction


def apply(model: RigModel, values: Values) -> RigModel:
    """F sign(v) at the excitation point; at 0 too, so that models of all values have the same unknowns."""
    return with_joint_element(model, "dry friction", CoulombFriction(), force=values["force"])


EFFECT = Effect(
    "joint_friction",
    "dry friction resists the motion: a loss that counts less the larger the amplitude",
    (
        EffectParameter(
            "force", 0.0, 0.0, 100.0, 0.1, "N",
            "a loss factor of a quarter of a per cent of a modal stiffness of 5e5 N/m at 0.1 mm", grows_with=(1, 1, 0),
        ),
    ),
    apply,
)  # fmt: skip
