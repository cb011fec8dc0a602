"""A joint that slides as a whole, as a friction damper does: stuck up to an amplitude, and let go beyond it."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.sliding_joint import SlidingJoint


def apply(model: RigModel, values: Values) -> RigModel:
    """A Jenkins element at the excitation point, whose stiffness the modes have while it sticks; at 0 too, so that
    models of all values have the same unknowns."""
    return with_joint_element(model, "slider", SlidingJoint(), lost=values["stiffness"], slip=values["slip"])


# The typical displacement is half of the largest amplitude: a joint that slips beyond that amplitude shows nothing.
EFFECT = Effect(
    "joint_slider",
    "beyond an amplitude the joint slides as a whole: its stiffness is gone, and friction takes energy",
    (
        EffectParameter(
            "stiffness", 0.0, 0.0, 3.75e5, 5e3, "N/m",
            "a per cent of a modal stiffness of 5e5 N/m; three quarters of it go at most", grows_with=(1, 0, 0),
        ),
        EffectParameter(
            "slip", 2.5e-5, 1e-8, 1e-4, 5e-5, "m", "half of 0.1 mm, the largest amplitude that was measured",
            grows_with=(0, 1, 0), shape=True,
        ),
    ),
    apply,
)  # fmt: skip
