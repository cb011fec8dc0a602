"""Loss in a joint that grows with the third power of the velocity."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.power_law_damper import PowerLawDamper


def apply(model: RigModel, values: Values) -> RigModel:
    """A damper at the excitation point; at 0 too, so that models of all values have the same unknowns."""
    law = PowerLawDamper(reference=1.0)
    return with_joint_element(model, "cubic damper", law, force=values["coefficient"], exponent=3.0)


# Sizes and bounds: the force at 0.1 mm and 80 Hz is that of `joint_quadratic`.
EFFECT = Effect(
    "joint_cubic_damping",
    "damping force grows with the third power of the velocity: the loss factor with the square of the amplitude",
    (
        EffectParameter(
            "coefficient", 0.0, 0.0, 2e5, 1e3, "N*s^3/m^3",
            "at 0.05 m/s as much as a square law of 50 N s^2/m^2", grows_with=(1, -2, -3),
        ),
    ),
    apply,
)  # fmt: skip
