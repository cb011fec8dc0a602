"""Geometrically nonlinear blades."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.springs import CubicSpring


def apply(model: RigModel, values: Values) -> RigModel:
    """A cubic spring at both tips; at 0 too, so that models of all values have the same unknowns."""
    return with_tip_elements(model, "cubic spring", CubicSpring(), coefficient=values["coefficient"])


EFFECT = Effect(
    "blade_cubic_stiffness",
    "the blades themselves get stiffer (or softer) with amplitude",
    (
        EffectParameter(
            "coefficient", 0.0, -1e13, 1e13, 1e12, "N/m^3",
            "about a per cent of the first mode's stiffness at 0.1 mm; slender cantilevers show less",
        ),
    ),
    apply,
)  # fmt: skip
