"""Contacts with a name: the patch of a face that is nearest to a place, and its motion and force over a period."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.static_contact.rest_state import FaceCoordinates
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.hbm.newton.observe import ContactState, force_loop
from updamp.parameter_study.families import ContactPlace, CurveName
from updamp.parameter_study.solved_study import SolvedStudy

Floats = NDArray[np.float64]

SIDES = {"left": LEFT, "right": RIGHT}


@dataclass(frozen=True, eq=False)
class ForceLoop:
    """motion: (n_time, 3) relative displacement along (t1, t2, n) [m]; force: (n_time, 3) less that at rest [N]
    preload: normal force at rest [N]; mu: friction coefficient; state: over the period"""

    name: str
    motion: Floats
    force: Floats
    preload: float
    mu: float
    state: ContactState

    @property
    def normal(self) -> Floats:
        """(n_time,) the whole normal force, pressing [N]"""
        return self.preload + self.force[:, 2]

    def first_harmonic(self, direction: int) -> complex:
        """Of the force along t1, t2 or n [N]."""
        spectrum = np.fft.rfft(self.force[:, direction])
        return complex(2 * spectrum[1] / len(self.force))


def nearest_patch(contacts: ContactElements, place: ContactPlace) -> int:
    """Number of the patch whose centroid is nearest to the place, both in lengths of the face."""
    coordinates = FaceCoordinates.of(contacts)
    up = 2 * coordinates.slope.mean(axis=1) / coordinates.length
    along = 2 * coordinates.along.mean(axis=1) / coordinates.width
    distance = np.hypot(up - place.up, along - place.along)
    return int(np.where(contacts.face == SIDES[place.face], distance, np.inf).argmin())


def distance_from_centre(contacts: ContactElements) -> Floats:
    """(n_patches,) of the centroids from their face's middle: 0 there, 1 at the middle of an edge."""
    coordinates = FaceCoordinates.of(contacts)
    up = 2 * coordinates.slope.mean(axis=1) / coordinates.length
    along = 2 * coordinates.along.mean(axis=1) / coordinates.width
    return np.hypot(up, along)


def loop_at(solved: SolvedStudy, name: CurveName, contact: str) -> ForceLoop:
    """At the peak of the curve. raises: UnknownResultError where it is missing or not complete; KeyError for a contact
    that the study does not name"""
    place = {one.name: one for one in solved.study.contacts}[contact]
    element = nearest_patch(solved.patches(name.variant), place)
    curve, model = solved.curve(name), solved.model(name.variant)
    i = solved.peak_of(name, curve).place
    w = 2 * np.pi * float(curve.frequency[i])
    motion, force = force_loop(model.system, curve.displacement[i], w, element)
    assert model.contacts is not None, "a rig with geometry has contacts"
    parameters = model.contacts.parameters
    preload, mu = float(np.asarray(parameters.n0)[element]), float(np.asarray(parameters.mu)[element])
    return ForceLoop(contact, motion, force, preload, mu, ContactState(int(solved.states(name)[element])))
