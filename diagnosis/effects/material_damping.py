"""Material damping that grows with amplitude.

eta = eta0 (1 + b A / 1 mm), A the amplitude of the tips, is realised by a damper f = c |u| v at each tip, whose loss
factor grows with A. c is such that the two modes that bend the blades lose, with all contacts stuck, what eta asks for,
on average over both: pi h_r q^2 b A = sum over the tips of 4/3 c omega_r |phi_tip q|^3, h_r the mode's hysteretic
damping and A the mean amplitude of both tips. Each mode alone differs from the average; at the reference rig's small
mesh by 9 %.
"""

import numpy as np

from updamp.diagnosis.effects.effect import Effect, EffectParameter, Values
from updamp.diagnosis.effects.tips import TIPS, with_tip_elements
from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.contact.amplitude_damper import AmplitudeDamper
from updamp.hbm.linear_model import LinearModel

PER = 1e-3  # m


def apply(model: RigModel, values: Values) -> RigModel:
    """A damper at both tips; at 0 too, so that models of all values have the same unknowns."""
    growth = values["growth"]
    coefficient = growth / PER * float(np.mean(coefficients(model))) if growth != 0 else 0.0
    return with_tip_elements(model, "amplitude damper", AmplitudeDamper(), coefficient=coefficient)


def coefficients(model: RigModel) -> tuple[float, float]:
    """c [N s/m^2] per unit of growth of the loss factor with the amplitude [1/m], for each of the two modes."""
    stuck = model.system.stuck
    found = []
    for mode in bending_modes(stuck):
        tips = np.abs(stuck.phi[[stuck.row(tip) for tip in TIPS], mode])
        omega, loss = np.sqrt(stuck.omega_squared[mode]), stuck.hysteretic[mode, mode]
        found.append(float(np.pi * loss * tips.mean() / (4 / 3 * omega * (tips**3).sum())))
    return found[0], found[1]


def bending_modes(stuck: LinearModel) -> list[int]:
    """The two modes with most of the tips' static flexibility, in phase and out of phase."""
    share = (stuck.phi[[stuck.row(tip) for tip in TIPS]] ** 2).sum(axis=0) / stuck.omega_squared
    return sorted(int(mode) for mode in np.argsort(-share)[:2])


EFFECT = Effect(
    "material_damping",
    "the blades' own damping grows with amplitude",
    (
        EffectParameter(
            "growth", 0.0, 0.0, 100.0, 10.0, "",
            "loss factor times 1 + growth x amplitude / 1 mm; doubled at 0.1 mm, as joints and roots of such rigs show",
        ),
    ),
    apply,
)  # fmt: skip
