"""Blades that get stiffer, or softer, in proportion to the amplitude."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.springs import SquareSpring


def apply(model: RigModel, values: Values) -> RigModel:
    """A spring of the second power at both tips; at 0 too, so that models of all values have the same unknowns."""
    return with_tip_elements(model, "square spring", SquareSpring(), coefficient=values["coefficient"])


# Sizes and bounds: the force at 0.1 mm is that of `blade_cubic_stiffness`.
EFFECT = Effect(
    "blade_square_stiffness",
    "the blades themselves get stiffer (or softer) in proportion to the amplitude, without loss",
    (
        EffectParameter(
            "coefficient", 0.0, -1e9, 1e9, 1e8, "N/m^2",
            "about a per cent of the first mode's stiffness at 0.1 mm; clamps and cracked metal soften so, by less",
        ),
    ),
    apply,
)  # fmt: skip
