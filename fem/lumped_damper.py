"""The lumped damper: a rigid mass with three translations, one contact element on each whole face.

The fast variant of Pesaresi et al. (2017). The blades stay as they are, seen through the average displacement of
their contact faces; the mass cannot roll, and a face slips and opens as a whole. `DAMPER_MODELS` are the choices that a
rig file can name, the elastic damper among them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]

FACES = (LEFT, RIGHT)


def lumped_damper(reduced: ReducedModel, rest: StaticContact) -> tuple[ReducedModel, StaticContact]:
    """The same rig with the damper as a point mass, and the rest state of its two contact elements.

    raises: ValueError where a face is not plane, so that it has no single normal
    """
    contacts = face_elements(reduced.contacts)
    mass = damper_mass(reduced)
    return (
        ReducedModel(
            blade_left=_through_average(reduced.blade_left, reduced.contacts, LEFT),
            blade_right=_through_average(reduced.blade_right, reduced.contacts, RIGHT),
            damper=_point_mass(reduced.damper, contacts, mass),
            contacts=contacts,
            max_relative_residual=reduced.max_relative_residual,
        ),
        rest_of_faces(rest, reduced.contacts),
    )


def face_elements(contacts: ContactElements) -> ContactElements:
    """One element a face, left then right: its whole area, at its centroid.

    A face is no triangle: the element's corners are those of a triangle of its area about its centroid, for the
    contracts' sake; nothing is integrated over it.

    raises: ValueError where a face is not plane
    """
    places = [np.flatnonzero(contacts.face == side) for side in FACES]
    for side, on in zip(("left", "right"), places, strict=True):
        if np.ptp(contacts.axes[on], axis=0).max(initial=0.0) > 1e-9:
            raise ValueError(f'damper_model = "lumped": the {side} contact face is not plane; use "elastic"')
    area = np.array([contacts.area[on].sum() for on in places])
    centroid = np.array([_weights(contacts, side) @ contacts.point[contacts.face == side] for side in FACES])
    t1, t2, n = (
        np.array([values[on[0]] for on in places]) for values in (contacts.tangent1, contacts.tangent2, contacts.normal)
    )
    side_length = np.sqrt(4 * area / np.sqrt(3))[:, None]
    around = np.deg2rad([90.0, 210.0, 330.0])
    corners = [centroid + side_length / np.sqrt(3) * (np.cos(a) * t1 + np.sin(a) * t2) for a in around]
    return ContactElements(np.array(FACES), centroid, area, t1, t2, n, np.stack(corners, axis=1))


def damper_mass(reduced: ReducedModel) -> float:
    """Of the elastic damper [kg], from its rigid-body modes: those of them that make up a unit translation have the
    modal amplitudes q with q^T q = m, since the modes are mass-normalised.

    raises: ValueError where the damper's rigid-body modes do not hold a translation
    """
    damper, n = reduced.damper, 3 * len(reduced.contacts)
    rigid = damper.phi[:n, damper.omega == 0]
    upwards = reduced.contacts.axes[:, :, 1].ravel()
    amplitudes, *_ = np.linalg.lstsq(rigid, upwards, rcond=None)
    if not np.allclose(rigid @ amplitudes, upwards, rtol=0, atol=1e-6):
        raise ValueError("the damper's rigid-body modes hold no translation along y: a free damper is needed")
    return float(amplitudes @ amplitudes)


def rest_of_faces(rest: StaticContact, contacts: ContactElements) -> StaticContact:
    """The forces of each face together; it is in contact where any of its patches is."""
    places = [contacts.face == side for side in FACES]
    return replace(
        rest,
        normal_force=np.array([rest.normal_force[on].sum() for on in places]),
        tangential_force=np.array([rest.tangential_force[on].sum(axis=0) for on in places]),
        gap=np.array([rest.gap[on].min() for on in places]),
    )


def _weights(contacts: ContactElements, side: int) -> Floats:
    area = contacts.area[contacts.face == side]
    return area / area.sum()


def _through_average(blade: ReducedComponent, contacts: ContactElements, side: int) -> ReducedComponent:
    """The blade with its patches' displacements averaged over the face; by virtual work a force on the face spreads
    over them by their areas."""
    points = len(blade.points)
    average = np.kron(_weights(contacts, side), np.eye(3))
    operator = np.zeros((3 + points, average.shape[1] + points))
    operator[:3, : average.shape[1]] = average
    operator[3:, average.shape[1] :] = np.eye(points)
    return replace(blade, phi=operator @ blade.phi, residual=operator @ blade.residual @ operator.T)


def _point_mass(damper: ReducedComponent, contacts: ContactElements, mass: float) -> ReducedComponent:
    """Translations along x, y, z; every named point moves alike, so that springs on it act on the mass."""
    along = np.array([np.eye(3)["xyz".index(point[-1])] for point in damper.points])
    phi = np.vstack([contacts.axes.reshape(-1, 3), along]) / np.sqrt(mass)
    return ReducedComponent(damper.name, np.zeros(3), phi, np.zeros((len(phi), len(phi))), damper.points)


@dataclass(frozen=True)
class DamperModel:
    """apply: from the reduced model of the finite elements and its rest state to those that vibrate
    element_of_patch: (n_patches,) number of the contact element that each patch of the mesh belongs to
    """

    apply: Callable[[ReducedModel, StaticContact], tuple[ReducedModel, StaticContact]]
    element_of_patch: Callable[[ContactElements], NDArray[np.int64]]


DAMPER_MODELS: Mapping[str, DamperModel] = MappingProxyType(
    {
        "elastic": DamperModel(
            apply=lambda reduced, rest: (reduced, rest),
            element_of_patch=lambda contacts: np.arange(len(contacts)),
        ),
        "lumped": DamperModel(
            apply=lumped_damper,
            element_of_patch=lambda contacts: contacts.face,
        ),
    }
)
