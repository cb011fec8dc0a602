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
from updamp.hbm.linear_model import LinearModel, from_reduced
from updamp.hbm.structural_changes import Attachment, attach
from updamp.hbm.system import Excitation, NonlinearSystem
from updamp.rig import Rig

Floats = NDArray[np.float64]


def rig_system(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> NonlinearSystem:
    """Blades and damper on its wires, coupled by one contact element a patch, or a face where the damper is lumped.

    As in Pesaresi et al. (2017) the dynamic problem starts from the preload without tangential force.
    """
    balance = rig.harmonic_balance
    reduced, rest = DAMPER_MODELS[rig.damper_model].apply(reduced, rest)
    linear = add_wires(from_reduced(reduced, rig.material.loss_factor), rig)
    contacts = contact_elements(reduced.contacts.area, rest, rig)
    return NonlinearSystem(linear, (contacts,), Harmonics(balance.harmonics), balance.time_samples)


def contact_elements(area: Floats, rest: StaticContact, rig: Rig) -> ElementGroup:
    """The rig's contact law on the first 3 n relative rows; area: (n,) of the contact elements [m^2]."""
    contact, n = rig.contact, len(area)
    parameters = FrictionParameters(
        # from numpy: jnp.full's type is "weak", and another value of mu would make the law be compiled again
        mu=jnp.asarray(np.full(n, contact.friction_coefficient)),
        kt=jnp.asarray(contact.tangential_stiffness * area),
        kn=jnp.asarray(contact.normal_stiffness * area),
        n0=jnp.asarray(rest.normal_force),
        t0=jnp.zeros((n, 2)),
        gap=jnp.asarray(rest.gap),
    )
    law = CONTACT_LAWS[contact.law](rig.harmonic_balance.cycles)
    return ElementGroup(law, parameters, np.arange(3 * n).reshape(n, 3))


def add_wires(model: LinearModel, rig: Rig) -> LinearModel:
    """The model with both wires."""
    return attach(model, wires(rig))


def wires(rig: Rig) -> tuple[Attachment, ...]:
    """Both wires: axial stiffness upwards ("wire_back.y", "wire_front.y"), tension over length sideways, and the
    restoring roll moment of a pull that acts above the centroid.

    The damper has no other support once all contacts are open, so the zero harmonic needs all six.
    """
    wire, sideways = rig.wire, rig.load.pull / 2 / rig.wire.length
    along = {"x": sideways, "y": wire.axial_stiffness / 2, "z": sideways}
    springs = [
        Attachment(f"wire_{end}.{axis}", {f"damper.wire_{end}.{axis}": 1.0}, stiffness=stiffness)
        for end in ("back", "front")
        for axis, stiffness in along.items()
    ]
    lever = 1 / (2 * rig.face_bottom[0])
    roll = {"damper.corner_right.y": lever, "damper.corner_left.y": -lever}
    return (*springs, Attachment("wire roll", roll, stiffness=rig.load.pull * wire.attachment_height))


def excitation(system: NonlinearSystem, rig: Rig, force: float) -> Excitation:
    """The shaker's force [N] at its point on the blade the rig names."""
    return Excitation(system.free.row(f"blade_{rig.excitation.blade}.excitation.x"), force)
