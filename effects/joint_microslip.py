"""Friction in a bolted joint that slips little by little.

Gross slip is taken to be out of reach. Then stiffness and slip force of the joint cannot be known: only what the joint
loses at an amplitude, and how that grows with it.
"""

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import with_joint_element
from updamp.hbm.contact.iwan import IwanMicroslip


def apply(model: RigModel, values: Values) -> RigModel:
    """Iwan's sliders at the excitation point; with nothing lost too, so that models of all values have the same
    unknowns."""
    return with_joint_element(
        model,
        "micro-slip in the joint",
        IwanMicroslip(),
        lost=values["stiffness_lost"],
        exponent=values["exponent"],
        nearness=0.0,
    )


EFFECT = Effect(
    "joint_microslip",
    "the joint's faces slip against each other, first at the edges, and more of them the larger the motion",
    (
        EffectParameter(
            "stiffness_lost", 0.0, 0.0, 1e6, 5e3, "N/m",
            "by 0.1 mm at the excitation point; a per cent of a beam's modal stiffness of 5e5 N/m, which shifts the "
            "resonance by half a per cent, as lap joints do", grows_with=(1, 0, 0),
        ),
        EffectParameter(
            "exponent", 0.0, -0.9, 1.0, -0.4, "",
            "chi of the distribution of slip displacements: damping grows with amplitude to the power 1 + chi; lap "
            "joints that were measured had -0.9 to 0 (Segalman 2005)", shape=True,
        ),
    ),
    apply,
)  # fmt: skip
