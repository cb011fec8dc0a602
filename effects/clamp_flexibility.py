"""Clamps that give way.

With Gamma_r = phi_r^T M R, R the rigid rotation about the clamp, mode r loads the clamp with the moment
omega_r^2 Gamma_r q_r, and a load f at the interface, by way of the modes that are left out, with rho^T f,
rho = R - phi Gamma. The clamp's angle theta follows from (1/c + Gamma^T omega^2 Gamma) theta = Gamma^T omega^2 q +
rho^T f, c its compliance, and is eliminated: exactly, but for the inertia of the modes that are left out. The static
flexibility grows by c R R^T.

Gamma is handed on by the finite elements (`ReducedComponent.momentum_about_clamp`): a reduced model has no M, and the
displacements of R at its points tell Gamma of the first modes alone. Taken from the field of least strain energy that
has them, that of the third bending mode had the wrong sign, which at seven times a resonance changed its peak by 5 %.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.effects.contact_faces import patches_of
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import BLADES, modes_of, with_modal_stiffness
from updamp.geometry.contact_elements import LEFT, RIGHT

Floats = NDArray[np.float64]


def apply(model: RigModel, values: Values) -> RigModel:
    """raises: ValueError where the model has no clamped blades, or does not say where they are"""
    if values["compliance"] == 0:
        return model
    for blade in BLADES:
        model = _softened(model, blade, values["compliance"])
    return model


def _softened(model: RigModel, blade: str, compliance: float) -> RigModel:
    components, modes = model.components, modes_of(model, blade)
    rotation = rigid_rotation(model, blade)
    gamma = participation(model, blade)
    moment = components.omega_squared[modes] * gamma
    turning = compliance / (1 + compliance * moment @ gamma)
    stiffness = np.diag(components.omega_squared)
    stiffness[np.ix_(modes, modes)] -= turning * np.outer(moment, moment)
    phi = components.phi.copy()
    left = rotation - phi[:, modes] @ gamma
    phi[:, modes] += turning * np.outer(left, moment)
    residual = components.residual + turning * np.outer(left, left)
    return with_modal_stiffness(replace(model, components=replace(components, phi=phi, residual=residual)), stiffness)


def participation(model: RigModel, blade: str) -> Floats:
    """(k,) phi_r^T M R of the blade's modes [kg^1/2 m].

    raises: ValueError where the model was not built by finite elements
    """
    if blade not in model.momentum_about_clamp:
        raise ValueError(f"clamp_flexibility needs the finite elements of {blade} (RigModel.momentum_about_clamp)")
    return np.asarray(model.rotation[:, modes_of(model, blade)].T @ model.momentum_about_clamp[blade])


def rigid_rotation(model: RigModel, blade: str) -> Floats:
    """(n_rows,) displacement of the model's rows under a unit rotation of one blade about its clamp, about z [m].

    raises: ValueError where the model does not say where the blade's clamp and points are
    """
    components, patches = model.components, patches_of(model)
    points = [p for p in components.points if p.startswith(f"{blade}.")]
    if missing := {f"{blade}.root", *(p.rpartition(".")[0] for p in points)} - set(model.places):
        raise ValueError(f"clamp_flexibility needs the places of {', '.join(sorted(missing))} (RigModel.places)")
    root = np.array(model.places[f"{blade}.root"])
    rotation = np.zeros(components.n_rows)
    on = np.flatnonzero(patches.face == (LEFT if blade == "blade_left" else RIGHT))
    # relative displacements are damper minus platform
    moved = -np.einsum("edx,ex->ed", patches.axes[on], _turned(patches.point[on] - root))
    rotation[(3 * on[:, None] + np.arange(3)).ravel()] = moved.ravel()
    for point in points:
        place, _, axis = point.rpartition(".")
        rotation[components.row(point)] = _turned(np.array(model.places[place]) - root)["xyz".index(axis)]
    return rotation


def _turned(arm: Floats) -> Floats:
    """z cross the arm."""
    return np.stack([-arm[..., 1], arm[..., 0], np.zeros(arm.shape[:-1])], axis=-1)


EFFECT = Effect(
    "clamp_flexibility",
    "the blades' roots are not rigidly held: the clamps rotate a little",
    (
        EffectParameter(
            "compliance", 0.0, 0.0, 5e-5, 4e-6, "rad/(N*m)",
            "lowers a 7 mm steel blade's first frequency by 0.7 %, as bolted or monobloc roots of such rigs do",
        ),
    ),
    apply,
)  # fmt: skip
