"""Stiffening, or softening, of a structure known by its modes that sets in late: with the fourth power of the
amplitude."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.springs import QuinticSpring


def apply(model: RigModel, values: Values) -> RigModel:
    """A spring of the fifth power at the excitation point; at 0 too, so that models of all values have the same
    unknowns."""
    return with_joint_element(model, "quintic spring", QuinticSpring(), coefficient=values["coefficient"])


# Sizes and bounds: the force at 0.1 mm is that of `joint_cubic`.
EFFECT = Effect(
    "joint_quintic",
    "the structure gets stiffer (or softer) with the fourth power of the amplitude, without loss",
    (
        EffectParameter(
            "coefficient", 0.0, -5e21, 5e21, 1e19, "N/m^5",
            "0.12 % of a modal stiffness of 5e5 N/m at 0.1 mm", grows_with=(1, -4, 0),
        ),
    ),
    apply,
)  # fmt: skip
