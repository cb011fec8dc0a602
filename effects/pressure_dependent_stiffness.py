"""Contact stiffness that depends on the pressure."""

from updamp.effects.contact_faces import entry, modify_contacts, patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.modified.pressure_stiffness import PressureStiffness


def apply(model: RigModel, values: Values) -> RigModel:
    """k = k0 (p/p0)^m for kt and kn, p the momentary pressure and p0 the mean of that at rest over both faces.

    p0 is that of the rig file: kt and kn are stated at it, and another preload is another stiffness. Where it is not
    known, p0 is that of the model given.
    """
    if values["exponent"] == 0:
        return model
    area, p0 = patches_of(model).area, model.stated_pressure
    if p0 is None:
        p0 = float(entry(model, "n0").sum() / area.sum())
    return modify_contacts(model, PressureStiffness, pressure_exponent=values["exponent"], mean_force=p0 * area)


EFFECT = Effect(
    "pressure_dependent_stiffness",
    "the contacts get stiffer where and while they are pressed harder",
    (
        EffectParameter(
            "exponent", 0.0, 0.0, 0.6, 0.2, "",
            "1/3 Hertz; 0.5 and below for rough metal surfaces (Medina, Nowell and Dini 2013; Greenwood and "
            "Williamson 1966 give nearly 1 for kn of fresh surfaces)",
        ),
    ),
    apply,
)  # fmt: skip
