"""Blades whose tips strike something beside them."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.stops import Stop


def apply(model: RigModel, values: Values) -> RigModel:
    """A spring behind a gap on one side of each tip; at 0 too, so that models of all values have the same unknowns."""
    return with_tip_elements(model, "stop", Stop(), stiffness=(values["left"], values["right"]), gap=values["gap"])


EFFECT = Effect(
    "blade_stop",
    "beyond an amplitude a tip strikes something beside it, and the blade is stiffer from there on",
    (
        EffectParameter("left", 0.0, 0.0, 1e6, 2e3, "N/m", "assumed: a few per cent of a first mode's stiffness"),
        EffectParameter("right", 0.0, 0.0, 1e6, 2e3, "N/m", "as the left one"),
        EffectParameter(
            "gap", 5e-6, 1e-8, 1e-3, 1e-5, "m", "assumed: within what the tips of such rigs reach in a test",
            shape=True,
        ),
    ),
    apply,
)  # fmt: skip
