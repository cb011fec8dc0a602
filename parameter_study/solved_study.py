"""A parameter study as far as it is solved: its curves by name, and what can be read off them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.design.solved_design import SolvedDesign
from updamp.effects.rig_model import RigModel
from updamp.fem.contact_places import nearest_patch
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.contact_elements import ContactElements
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.model.force_loops import ForceLoop, loop_of_contact
from updamp.parameter_study.families import CurveName, ParameterStudy
from updamp.parameter_study.mode_peak import Peak, peak_of_mode
from updamp.rig.rig import Rig

Integers = NDArray[np.int64]


class UnknownResultError(ValueError):
    """What the study does not have, with the reason: a curve that is missing or not complete."""


@dataclass(eq=False)
class SolvedStudy:
    """variants: solved as far as they are asked; missing: why a curve is not there; folder: of all that is written"""

    study: ParameterStudy
    folder: Path
    rig: Rig
    variants: Mapping[str, SolvedDesign]
    curves: Mapping[CurveName, ResponseCurve]
    missing: Mapping[CurveName, str] = field(default_factory=dict)
    seconds: float = 0.0
    _states: dict[CurveName, Any] = field(default_factory=dict)

    def point(self, variant: str) -> str:
        """Where its peaks are taken: the tip of the blade that it is excited at."""
        return self.variants[variant].observed

    @property
    def forces(self) -> tuple[float, ...]:
        """Levels of the rig file, rising [N]"""
        return tuple(sorted(self.rig.study.force_levels))

    def curve(self, name: CurveName) -> ResponseCurve:
        """raises: UnknownResultError where it is missing or not complete"""
        if name not in self.curves:
            raise UnknownResultError(f"{name.label}: {self.missing.get(name, 'not part of this study')}")
        if not (curve := self.curves[name]).complete:
            raise UnknownResultError(f"{name.label}: not complete: {curve.stopped or 'it has no point'}")
        return curve

    def peak(self, name: CurveName) -> Peak:
        """raises: UnknownResultError as `curve`, and where the largest response is at an end of the window"""
        curve = self.curve(name)
        peak = self.peak_of(name, curve)
        if peak.place in (0, len(curve) - 1):
            raise UnknownResultError(f"{name.label}: no peak in the window; the response is largest at its end")
        return peak

    def peak_of(self, name: CurveName, curve: ResponseCurve) -> Peak:
        """Of a curve of this name, complete or not."""
        (reference,) = (one for one in self.variants[name.variant].given.references if one.name == name.mode)
        return peak_of_mode(curve, self.point(name.variant), reference)

    def model(self, variant: str) -> RigModel:
        """raises: UnknownResultError where it cannot be built"""
        try:
            return self.variants[variant].model
        except (KeyError, ValueError, RuntimeError) as error:
            raise UnknownResultError(f"{variant}: {error}") from None

    def rest(self, variant: str) -> StaticContact:
        """Of the patches. raises: UnknownResultError as `model`"""
        self.model(variant)
        return self.variants[variant].rest

    def patches(self, variant: str) -> ContactElements:
        patches = self.model(variant).patches
        assert patches is not None, "a rig with geometry has contact patches"
        return patches

    def states(self, name: CurveName) -> Integers:
        """(n_contacts,) ContactState of each contact element over a period at the peak. raises: as `curve`"""
        if name not in self._states:
            curve = self.curve(name)
            place = self.peak_of(name, curve).place
            w = 2 * np.pi * float(curve.frequency[place])
            self._states[name] = contact_states(self.model(name.variant).system, curve.displacement[place], w)
        found: Integers = self._states[name]
        return found[: len(self.patches(name.variant))]


def loop_at(solved: SolvedStudy, name: CurveName, contact: str) -> ForceLoop:
    """At the peak of the curve. raises: UnknownResultError where it is missing or not complete; KeyError for a contact
    that the study does not name"""
    place = {one.name: one for one in solved.study.contacts}[contact]
    element = nearest_patch(solved.patches(name.variant), place)
    curve, model = solved.curve(name), solved.model(name.variant)
    i = solved.peak_of(name, curve).place
    state = ContactState(int(solved.states(name)[element]))
    return loop_of_contact(model, curve.displacement[i], 2 * np.pi * float(curve.frequency[i]), element, contact, state)
