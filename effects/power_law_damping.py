"""Damping of the blades' tips that grows with a power of their velocity."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.power_law_damper import PowerLawDamper

# m/s: an amplitude of 36 um at 440 Hz, in the midst of what tips of such rigs reach.
REFERENCE_VELOCITY = 0.1


def apply(model: RigModel, values: Values) -> RigModel:
    """F |v / v0|^p sign(v) at both tips, v0 = 0.1 m/s; at 0 too, so that models of all values have the same
    unknowns."""
    law = PowerLawDamper(REFERENCE_VELOCITY)
    return with_tip_elements(model, "damper", law, force=values["force"], exponent=values["exponent"])


# At an exponent of 1 it would be a dashpot, which a loss factor imitates: the search begins at 2.
EFFECT = Effect(
    "power_law_damping",
    "damping force at the tips grows with a power of their velocity, as drag or air pumped out of gaps makes it",
    (
        EffectParameter(
            "force", 0.0, 0.0, 100.0, 0.2, "N",
            "at 0.1 m/s; assumed: with a square law as much as a loss factor of half a per cent at 0.02 mm",
        ),
        EffectParameter(
            "exponent", 2.0, 1.0, 3.0, 2.5, "",
            "1 of a laminar film, 2 of drag and of air through gaps, 3 of losses with the third power", (1.0,),
            shape=True,
        ),
    ),
    apply,
)  # fmt: skip
