"""Stiffening, or softening, of a structure known by its modes that sets in early: with the amplitude itself."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.springs import SquareSpring


def apply(model: RigModel, values: Values) -> RigModel:
    """A spring of the second power at the excitation point; at 0 too, so that models of all values have the same
    unknowns."""
    return with_joint_element(model, "square spring", SquareSpring(), coefficient=values["coefficient"])


# Sizes and bounds: the force at 0.1 mm is that of `joint_cubic`.
EFFECT = Effect(
    "joint_square",
    "the structure gets stiffer (or softer) in proportion to the amplitude, without loss",
    (
        EffectParameter(
            "coefficient", 0.0, -5e9, 5e9, 1e7, "N/m^2",
            "0.17 % of a modal stiffness of 5e5 N/m at 0.1 mm; rock, concrete and cracked metal soften so, by up to "
            "some per cent", grows_with=(1, -1, 0),
        ),
    ),
    apply,
)  # fmt: skip
