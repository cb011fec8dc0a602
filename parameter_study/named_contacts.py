"""Force loops of the contacts that a study names, at the peaks of its curves."""

import numpy as np

from updamp.fem.contact_places import nearest_patch
from updamp.hbm.newton.observe import ContactState
from updamp.model.force_loops import ForceLoop, loop_of_contact
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.solved_study import SolvedStudy


def loop_at(solved: SolvedStudy, name: CurveName, contact: str) -> ForceLoop:
    """At the peak of the curve. raises: UnknownResultError where it is missing or not complete; KeyError for a contact
    that the study does not name"""
    place = {one.name: one for one in solved.study.contacts}[contact]
    element = nearest_patch(solved.patches(name.variant), place)
    curve, model = solved.curve(name), solved.model(name.variant)
    i = solved.peak_of(name, curve).place
    state = ContactState(int(solved.states(name)[element]))
    return loop_of_contact(model, curve.displacement[i], 2 * np.pi * float(curve.frequency[i]), element, contact, state)
