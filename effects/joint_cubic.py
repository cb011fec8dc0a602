"""Geometric stiffening, or softening, of a structure known by its modes."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.springs import CubicSpring


def apply(model: RigModel, values: Values) -> RigModel:
    """A cubic spring at the excitation point; at 0 too, so that models of all values have the same unknowns."""
    return with_joint_element(model, "cubic spring", CubicSpring(), coefficient=values["coefficient"])


# Bounds: three quarters of the modal stiffness at 0.1 mm. Beyond that no one harmonic describes a motion.
EFFECT = Effect(
    "joint_cubic",
    "the structure gets stiffer (or softer) with the square of the amplitude, without loss",
    (
        EffectParameter(
            "coefficient", 0.0, -5e13, 5e13, 1e11, "N/m^3",
            "0.15 % of a modal stiffness of 5e5 N/m at 0.1 mm", grows_with=(1, -2, 0),
        ),
    ),
    apply,
)  # fmt: skip
