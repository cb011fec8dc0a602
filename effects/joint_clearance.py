"""A structure known by its modes that meets something, or in which something opens, beyond an amplitude."""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.stops import Clearance


def apply(model: RigModel, values: Values) -> RigModel:
    """A spring with a gap both ways at the excitation point; at 0 too, so that models of all values have the same
    unknowns. A stop on one side alone shows as one of half its stiffness on both."""
    return with_joint_element(model, "clearance", Clearance(), stiffness=values["stiffness"], gap=values["gap"])


# Bounds: what opens takes no more than three quarters of the modal stiffness with it; a stop may be far stiffer than
# the structure. The typical gap is half of the largest amplitude: beyond that amplitude a gap shows nothing.
EFFECT = Effect(
    "joint_clearance",
    "beyond an amplitude the structure is stiffer, as where a stop is met, or softer, as where a pressed joint opens",
    (
        EffectParameter(
            "stiffness", 0.0, -3.75e5, 5e6, 5e3, "N/m", "a per cent of a modal stiffness of 5e5 N/m",
            grows_with=(1, 0, 0),
        ),
        EffectParameter(
            "gap", 2.5e-5, 1e-8, 1e-4, 5e-5, "m", "half of 0.1 mm, the largest amplitude that was measured",
            grows_with=(0, 1, 0), shape=True,
        ),
    ),
    apply,
)  # fmt: skip
