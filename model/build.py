"""The one builder: from a rig and the stages before to the model that is solved, compared and diagnosed.

What a rig has taken up is applied in one order everywhere: calibration first, then effects, as a fit applies them.
"""

from collections.abc import Iterator, Mapping

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from updamp.effects.chosen import resolved, with_tried_effects
from updamp.effects.rig_model import PointElement, RigModel
from updamp.fem.lumped_damper import DAMPER_MODELS
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.hbm.contact import CONTACT_LAWS
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.structural_changes import Attachment
from updamp.model.calibration import calibrated
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig
from updamp.rig.wires import wire_springs

Floats = NDArray[np.float64]
Point = tuple[float, float, float]


def rig_model(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """Blades and damper on its wires, coupled by one contact element a patch, or a face where the damper is lumped,
    with the calibration and the effects that the rig's file has taken up.

    As in Pesaresi et al. (2017) the dynamic problem starts from the preload without tangential force.
    raises: ValueError naming an effect or factor that the rig has no place for
    """
    return with_tried_effects(rig_before_effects(reduced, rest, rig), resolved(rig.effects))


def rig_before_effects(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """The rig with the calibration of its file: the base of a `Parametrisation`, which applies the effects itself.

    raises: ValueError naming a factor that the rig has no place for
    """
    return calibrated(as_built(reduced, rest, rig), rig.calibration)


def modal_model(rig: ModalRig) -> RigModel:
    """A rig given by modes, with the calibration and the effects of its file.

    raises: ValueError naming an effect or factor that the model has no place for
    """
    return with_tried_effects(modal_before_effects(rig), resolved(rig.effects))


def modal_before_effects(rig: ModalRig) -> RigModel:
    """As `rig_before_effects`."""
    return calibrated(_as_identified(rig), rig.calibration)


def as_built(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """Before calibration and effects.

    Only the study's damper model is applied; harmonics, samples and law are those of the rig file.
    """
    reduced, rest = DAMPER_MODELS[rig.damper_model].apply(reduced, rest)
    return RigModel(
        components=from_reduced(reduced, rig.loss_factors),
        owner=tuple(component.name for component in reduced.components for _ in component.omega),
        attachments=wire_attachments(rig),
        by_pull=tuple(spring.name for spring in wire_springs(rig) if spring.by_pull),
        contacts=contact_group(reduced.contacts.area, rest, rig),
        patches=reduced.contacts,
        excitation=rig.excitation.point,
        harmonics=Harmonics(rig.harmonic_balance.harmonics),
        time_samples=rig.harmonic_balance.time_samples,
        places=_places(rig),
        stated_pressure=float(rest.normal_force.sum() / reduced.contacts.area.sum()),
        momentum_about_clamp=_momenta_about_clamps(reduced),
        residual_of=residual_flexibility(reduced),
        windows=rig.windows,
    )


def _momenta_about_clamps(reduced: ReducedModel) -> dict[str, Floats]:
    """Of the components that are clamped, in the modes of all."""
    found, first, n = {}, 0, sum(len(component.omega) for component in reduced.components)
    for component in reduced.components:
        if len(component.momentum_about_clamp):
            found[component.name] = np.zeros(n)
            found[component.name][first : first + len(component.omega)] = component.momentum_about_clamp
        first += len(component.omega)
    return found


def _as_identified(rig: ModalRig) -> RigModel:
    """Its modes as one component; parameters are those of modes identified in a test (`RigModel.identified`)."""
    balance, modes = rig.harmonic_balance, tuple(rig.modes.values())
    omega = 2 * np.pi * np.array([mode.frequency for mode in modes])
    eta = np.array([mode.loss_factor or 0.0 for mode in modes])
    zeta = np.array([mode.damping_ratio or 0.0 for mode in modes])
    shapes = [mode.normalised for mode in modes]
    phi = np.array([[shape.get(point, 0.0) for shape in shapes] for point in rig.points])
    n = len(rig.points)
    components = LinearModel(
        omega**2, phi, np.zeros((n, n)), np.diag(eta * omega**2), np.diag(2 * zeta * omega), 0, rig.points
    )
    # The solver needs a relative displacement; a spring of no stiffness gives it one and changes nothing.
    nothing = PointElement("none", (rig.excitation,), CubicSpring(), CubicParameters(jnp.asarray(np.zeros(1))))
    return RigModel(
        components=components,
        owner=(rig.name,) * len(modes),
        attachments=(),
        contacts=None,
        patches=None,
        excitation=rig.excitation,
        harmonics=Harmonics(balance.harmonics),
        time_samples=balance.time_samples,
        elements=(nothing,),
        identified=True,
        modes=tuple(rig.modes),
        windows=rig.windows,
    )


def contact_group(area: Floats, rest: StaticContact, rig: Rig) -> ElementGroup:
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


def wire_attachments(rig: Rig) -> tuple[Attachment, ...]:
    """The wires' springs (`rig/wires.py`), at the damper's points."""
    return tuple(
        Attachment(
            spring.name,
            {f"damper.{point}": factor for point, factor in spring.points.items()},
            stiffness=spring.stiffness,
        )
        for spring in wire_springs(rig)
    )


def _places(rig: Rig) -> dict[str, Point]:
    """Of the blades' clamps and points; the left blade is the mirror image of the right one."""
    middle, outer = rig.blade.axis_offset, rig.blade.axis_offset + rig.blade.thickness / 2
    right = {
        "root": (middle, 0.0, 0.0),
        "excitation": (outer, rig.excitation.height, 0.0),
        "tip": (outer, rig.response_height, 0.0),
        "platform": (rig.platform.gap / 2, rig.platform.top, 0.0),
    }
    return {
        f"blade_{side}.{name}": (sign * x, y, z)
        for side, sign in (("left", -1.0), ("right", 1.0))
        for name, (x, y, z) in right.items()
    }


def from_reduced(reduced: ReducedModel, loss_factors: Mapping[str, float]) -> LinearModel:
    """Both blades and the damper, not yet coupled.

    loss_factors: component -> of its material, and so of its modes
    Points are named component.point, such as "blade_right.tip.x".
    """
    points = tuple(f"{c.name}.{p}" for c in reduced.components for p in c.points)
    omega_squared = np.concatenate([c.omega for c in reduced.components]) ** 2
    loss = np.concatenate([np.full(len(c.omega), loss_factors[c.name]) for c in reduced.components])
    return LinearModel(
        omega_squared=omega_squared,
        phi=np.hstack([rows @ c.phi for c, rows in zip(reduced.components, _rows_of(reduced), strict=True)]),
        residual=np.sum([*residual_flexibility(reduced).values()], axis=0),
        hysteretic=np.diag(loss * omega_squared),
        viscous=np.zeros((len(omega_squared), len(omega_squared))),
        n_relative=3 * len(reduced.contacts),
        points=points,
    )


def residual_flexibility(reduced: ReducedModel) -> dict[str, Floats]:
    """Component -> (n_rows, n_rows) its own, in the rows of all [m/N]."""
    return {c.name: rows @ c.residual @ rows.T for c, rows in zip(reduced.components, _rows_of(reduced), strict=True)}


def _rows_of(reduced: ReducedModel) -> Iterator[Floats]:
    """Of each component (n_rows, its rows): where they are among those of all, signed by its side of a contact."""
    start = 3 * len(reduced.contacts)
    n_rows = start + sum(len(c.points) for c in reduced.components)
    for component, sign, rows in zip(reduced.components, reduced.contact_sign(), reduced.contact_rows(), strict=True):
        select, points = np.zeros((n_rows, len(component.residual))), np.arange(len(component.points))
        select[rows, np.arange(len(rows))] = sign
        select[start + points, len(rows) + points] = 1
        start += len(points)
        yield select
