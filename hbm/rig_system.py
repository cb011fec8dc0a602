"""From the reduced model, the rest state and the rig to the coupled problem."""

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.fem.contact_rest import StaticContact
from updamp.fem.damper_models import DAMPER_MODELS
from updamp.fem.reduced_model import ReducedModel
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.registry import CONTACT_LAWS
from updamp.hbm.elements import ElementGroup
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.linear_model import LinearModel, add_springs, from_reduced
from updamp.hbm.system import Excitation, NonlinearSystem
from updamp.rig import Rig

Floats = NDArray[np.float64]


def rig_system(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> NonlinearSystem:
    """Blades and damper on its wires, coupled by one contact element a patch, or a face where the damper is lumped.

    As in Pesaresi et al. (2017) the dynamic problem starts from the preload without tangential force.
    """
    contact, balance = rig.contact, rig.harmonic_balance
    reduced, rest = DAMPER_MODELS[rig.damper_model].apply(reduced, rest)
    area, n = reduced.contacts.area, len(reduced.contacts)
    parameters = FrictionParameters(
        mu=jnp.full(n, contact.friction_coefficient),
        kt=jnp.asarray(contact.tangential_stiffness * area),
        kn=jnp.asarray(contact.normal_stiffness * area),
        n0=jnp.asarray(rest.normal_force),
        t0=jnp.zeros((n, 2)),
        gap=jnp.asarray(rest.gap),
    )
    group = ElementGroup(CONTACT_LAWS[contact.law](balance.cycles), parameters, np.arange(3 * n).reshape(n, 3))
    linear = add_wires(from_reduced(reduced, rig.material.loss_factor), rig)
    return NonlinearSystem(linear, (group,), Harmonics(balance.harmonics), balance.time_samples)


def add_wires(model: LinearModel, rig: Rig) -> LinearModel:
    """The model with both wires: axial stiffness upwards, tension over length sideways, and the restoring roll
    moment of a pull that acts above the centroid.

    The damper has no other support once all contacts are open, so the zero harmonic needs all six.
    """
    wire, tension = rig.wire, rig.load.pull / 2
    directions, stiffness = [], []
    for end in ("back", "front"):
        for axis, k in (("x", tension / wire.length), ("y", wire.axial_stiffness / 2), ("z", tension / wire.length)):
            directions.append(_unit(model, f"damper.wire_{end}.{axis}"))
            stiffness.append(k)
    half_width = rig.face_bottom[0]
    roll = _unit(model, "damper.corner_right.y") - _unit(model, "damper.corner_left.y")
    directions.append(roll / (2 * half_width))
    stiffness.append(rig.load.pull * wire.attachment_height)
    return add_springs(model, np.stack(directions, axis=1), np.array(stiffness))


def _unit(model: LinearModel, point: str) -> Floats:
    return np.eye(1, model.n_rows, model.row(point))[0]


def excitation(system: NonlinearSystem, rig: Rig, force: float) -> Excitation:
    """The shaker's force [N] at its point on the blade the rig names."""
    return Excitation(system.free.row(f"blade_{rig.excitation.blade}.excitation.x"), force)
