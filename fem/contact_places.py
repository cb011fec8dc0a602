"""Places on the contact faces that have a name, and the patch that is nearest to one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.static_contact.rest_state import FaceCoordinates
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]

SIDES = {"left": LEFT, "right": RIGHT}


@dataclass(frozen=True)
class ContactPlace:
    """face: "left" or "right"; up, along: from -1 to 1 up the slope and along the damper"""

    name: str
    face: str
    up: float
    along: float


# Upper edge, centre and lower edge of the right face at mid-width and at the damper's end, and of the left face at
# mid-width: in the manner of Fig. 19 of Pesaresi et al. (2017), which does not say in words where its contacts lie.
NINE_PLACES = (
    *(ContactPlace(f"A{i}", "right", up, 0.0) for i, up in ((1, 1.0), (2, 0.0), (3, -1.0))),
    *(ContactPlace(f"A{i}", "right", up, 1.0) for i, up in ((4, 1.0), (5, 0.0), (6, -1.0))),
    *(ContactPlace(f"B{i}", "left", up, 0.0) for i, up in ((1, 1.0), (2, 0.0), (3, -1.0))),
)


def nearest_patch(contacts: ContactElements, place: ContactPlace) -> int:
    """Number of the patch whose centroid is nearest to the place, both in lengths of the face."""
    up, along = _places(contacts)
    distance = np.hypot(up - place.up, along - place.along)
    return int(np.where(contacts.face == SIDES[place.face], distance, np.inf).argmin())


def distance_from_centre(contacts: ContactElements) -> Floats:
    """(n_patches,) of the centroids from their face's middle: 0 there, 1 at the middle of an edge."""
    return np.hypot(*_places(contacts))


def _places(contacts: ContactElements) -> tuple[Floats, Floats]:
    """(n_patches,) of the centroids, -1 to 1 up the slope and along the damper"""
    coordinates = FaceCoordinates.of(contacts)
    up = 2 * coordinates.slope.mean(axis=1) / coordinates.length
    return up, 2 * coordinates.along.mean(axis=1) / coordinates.width
