"""Pressure that rises along the damper."""

from updamp.effects.contact_faces import along_damper, entry, patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel


def apply(model: RigModel, values: Values) -> RigModel:
    """n0 (1 + slope s), s along the damper."""
    s = along_damper(patches_of(model))
    return model.with_contacts(n0=entry(model, "n0") * (1 + values["slope"] * s))


EFFECT = Effect(
    "pressure_slope",
    "the damper is pulled askew: one end is pressed harder than the other",
    (EffectParameter("slope", 0.0, -0.95, 0.95, 0.5, "", "assumed: the wires' pulls differ by a sixth of their sum"),),
    apply,
    # Blades that bend see both ends alike: what is left of first order comes from the damper's patches not being laid
    # symmetrically, and from torsion.
    finite_step=True,
)
