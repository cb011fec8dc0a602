"""A joint with a viscoelastic layer: a spring and a dashpot in series (Maxwell) beside the joint's own stiffness, which
together are the standard linear solid.

The place between spring and dashpot becomes a point of its own, with so little mass that it moves as if it had none.
"""

from dataclasses import replace

import numpy as np

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import joint_model, joint_of
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.structural_changes import Attachment

POINT = "joint.layer.x"
# Frequency of the inner point on its spring, over the highest of the modes.
_FAR_ABOVE = 1e3


def apply(model: RigModel, values: Values) -> RigModel:
    """Nothing at a stiffness of nil."""
    stiffness, time = values["stiffness"], values["relaxation_time"]
    if stiffness == 0:
        return joint_model(model)
    inner = _with_point(joint_model(model).components, stiffness)
    layer = (
        Attachment("layer's spring", {joint_of(model): 1.0, POINT: -1.0}, stiffness),
        Attachment("layer's dashpot", {POINT: 1.0}, dashpot=stiffness * time),
    )
    owner = (*model.owner, "joint")
    return replace(model, components=inner, owner=owner, attachments=(*model.attachments, *layer))


def _with_point(components: LinearModel, stiffness: float) -> LinearModel:
    """With a free point mass as one mode more."""
    mass = stiffness / (_FAR_ABOVE**2 * float(components.omega_squared.max()))
    n, m = components.phi.shape
    phi = np.zeros((n + 1, m + 1))
    phi[:n, :m], phi[n, m] = components.phi, mass**-0.5
    return replace(
        components,
        omega_squared=np.append(components.omega_squared, 0.0),
        phi=phi,
        residual=np.pad(components.residual, (0, 1)),
        hysteretic=np.pad(components.hysteretic, (0, 1)),
        viscous=np.pad(components.viscous, (0, 1)),
        points=(*components.points, POINT),
        basis=None,
    )


EFFECT = Effect(
    "joint_viscoelastic",
    "a viscoelastic layer in the joint adds stiffness and loss that depend on frequency, not on amplitude",
    (
        EffectParameter(
            "stiffness", 0.0, 0.0, 1e6, 5e3, "N/m", "a per cent of a modal stiffness of 5e5 N/m", (), (1, 0, 0)
        ),
        EffectParameter(
            "relaxation_time",
            2e-3,
            1e-5,
            1.0,
            1e-3,
            "s",
            "most loss at 80 Hz and 160 Hz; polymers have any",
            grows_with=(0, 0, -1),
            shape=True,
        ),
    ),
    apply,
)
