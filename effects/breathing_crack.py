"""Blades with a crack that is pressed shut and opens beyond an amplitude."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_tip_elements
from updamp.hbm.contact.stops import Stop


def apply(model: RigModel, values: Values) -> RigModel:
    """What a blade loses of its stiffness on the way that opens the crack, seen at its tip; at 0 too, so that models of
    all values have the same unknowns."""
    lost = -values["left"], -values["right"]
    return with_tip_elements(model, "crack", Stop(), stiffness=lost, gap=values["opening"])


# A crack that is never pressed shut (opening 0) is a blade of other frequency and an even harmonic: the first harmonic
# of a bilinear spring is that of a linear one of half the difference (Chati, Rand and Mukherjee 1997). Bounds: no more
# than half of a first mode's stiffness at the tip opens.
EFFECT = Effect(
    "breathing_crack",
    "beyond an amplitude a blade is softer one way, as where a crack that is pressed shut opens",
    (
        EffectParameter("left", 0.0, 0.0, 5e4, 2e3, "N/m", "assumed: a few per cent of a first mode's stiffness"),
        EffectParameter("right", 0.0, 0.0, 5e4, 2e3, "N/m", "as the left one"),
        EffectParameter(
            "opening", 5e-6, 1e-8, 1e-3, 1e-5, "m", "assumed: within what the tips of such rigs reach in a test",
            shape=True,
        ),
    ),
    apply,
)  # fmt: skip
