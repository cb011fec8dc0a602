"""Material damping of the blades that grows with amplitude.

eta = eta0 (1 + b A / 1 mm), A the amplitude of each blade's tip, is realised by dampers at the tips whose loss factor
grows with A (`PairedAmplitudeDamper`), one coefficient for what both blades do in phase and one for out of phase, since
the two modes that bend the blades have other shapes. Both are such that these modes lose, with all contacts stuck, what
eta asks for: pi h_r q^2 b A = sum over the tips of 4/3 c omega_r |phi_tip q|^3, h_r the blades' share of the mode's
hysteretic damping and A the mean amplitude of both tips.
"""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import PointElement, RigModel
from updamp.effects.structure import TIPS, model_with
from updamp.hbm.contact.paired_amplitude_damper import PairedAmplitudeDamper, PairedAmplitudeDamperParameters
from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]

PER = 1e-3  # m


def apply(model: RigModel, values: Values) -> RigModel:
    """Dampers at both tips; at 0 too, so that models of all values have the same unknowns.

    raises: ValueError where the model lacks one of the tips
    """
    model_with(model, TIPS)
    growth = values["growth"] / PER
    each = [growth * c for c in coefficients(model)] if growth != 0 else [0.0, 0.0]
    law, parameters = PairedAmplitudeDamper(), PairedAmplitudeDamperParameters(*(jnp.full(1, c) for c in each))
    return replace(model, elements=(*model.elements, PointElement("amplitude dampers", TIPS, law, parameters)))


def coefficients(model: RigModel) -> tuple[float, float]:
    """c [N s/m^2] per unit of growth of the loss factor with the amplitude [1/m], in phase and out of phase."""
    stuck, lost = model.system.stuck, _by_blades(model)
    found: dict[bool, float] = {}
    for mode in bending_modes(stuck):
        tips = stuck.phi[[stuck.row(tip) for tip in TIPS], mode]
        sizes, omega = np.abs(tips), np.sqrt(stuck.omega_squared[mode])
        c = float(np.pi * lost[mode] * sizes.mean() / (4 / 3 * omega * (sizes**3).sum()))
        found.setdefault(bool(tips.prod() > 0), c)
    # blades far from alike may bend one at a time: then in phase and out of phase are the same
    both = float(np.mean(list(found.values())))
    return found.get(True, both), found.get(False, both)


def _by_blades(model: RigModel) -> Floats:
    """(m,) hysteretic damping of the stuck modes that the blades account for."""
    blades = {tip.split(".")[0] for tip in TIPS}
    own = np.array([owner in blades for owner in model.owner])
    hysteretic = model.components.hysteretic * np.outer(own, own)
    alone = replace(model, components=replace(model.components, hysteretic=hysteretic))
    return np.diag(alone.system.stuck.hysteretic)


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
