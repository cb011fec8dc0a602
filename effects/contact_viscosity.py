"""A film in the contact."""

from updamp.effects.contact_faces import modify_contacts, patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.hbm.contact.modified.film import ViscousFilm


def apply(model: RigModel, values: Values) -> RigModel:
    """A dashpot of c times the area in t1, t2 and n while in contact."""
    if values["viscosity"] == 0:
        return model
    return modify_contacts(model, ViscousFilm, viscosity=values["viscosity"] * patches_of(model).area)


EFFECT = Effect(
    "contact_viscosity",
    "a film of oil, wear debris or oxide in the contact damps every relative motion",
    (
        EffectParameter(
            "viscosity", 0.0, 0.0, 5e9, 1e8, "N*s/m^3",
            "assumed: the contact stiffness with a loss factor of half a per cent at 440 Hz",
        ),
    ),
    apply,
)  # fmt: skip
