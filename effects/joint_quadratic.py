"""Loss in a joint that grows with the square of the velocity."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.power_law_damper import PowerLawDamper


def apply(model: RigModel, values: Values) -> RigModel:
    """A damper at the excitation point; at 0 too, so that models of all values have the same unknowns."""
    law = PowerLawDamper(reference=1.0)
    return with_joint_element(model, "quadratic damper", law, force=values["coefficient"], exponent=2.0)


EFFECT = Effect(
    "joint_quadratic",
    "damping force grows with the square of the velocity, as air pumped out of gaps or drag makes it",
    (
        EffectParameter(
            "coefficient", 0.0, 0.0, 1e4, 50.0, "N*s^2/m^2",
            "at 0.1 m/s as a dashpot of some 4 N s/m; drag of the air on a beam of this size is below 0.1",
            grows_with=(1, -1, -2),
        ),
    ),
    apply,
)  # fmt: skip
