"""The contact faces: what share of them sticks, slips or separates over a period, and the largest pressure."""

from collections.abc import Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from updamp.design.responses.response import AtPeak, Response, response
from updamp.design.solved_design import SolvedDesign
from updamp.design.solved_peak import PeakRequest
from updamp.effects.rig_model import RigModel
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.hbm.problem.elements import over_period
from updamp.rig.rig import Force

_SAMPLES = 256
_STATES: Mapping[str, tuple[ContactState, ...]] = {
    "stuck": (ContactState.STUCK,),
    "slipping": (ContactState.STICK_SLIP,),
    "separated": (ContactState.SEPARATING, ContactState.NEVER_IN_CONTACT),
}


@response("contact_share")
class ContactShare(AtPeak):
    """Share of the contact area, 0 to 1, that over a period at the resonance is all the time stuck, slips at some time
    and never opens, or is open at some time (separated)."""

    of_geometry: ClassVar[bool] = True
    state: Literal["stuck", "slipping", "separated"]

    def value(self, design: SolvedDesign) -> float:
        peak, area = self.peak(design), _areas(design.model)
        states = contact_states(design.model.system, peak.displacement, 2 * np.pi * peak.frequency)[: len(area)]
        return float(area[np.isin(states, _STATES[self.state])].sum() / area.sum())


@response("largest_pressure")
class LargestPressure(Response):
    """Of all contact elements: at rest, or over a period at a mode's resonance where mode and force are given."""

    unit: ClassVar[str] = "MPa"
    of_geometry: ClassVar[bool] = True
    mode: str | None = None
    force: Force | None = None
    by: Literal["resonance", "resonance_only", "curve"] = "resonance"

    @model_validator(mode="after")
    def _both(self) -> Self:
        if (self.mode is None) != (self.force is None):
            raise ValueError("mode, force: give both for the pressure at a resonance, or none for that at rest")
        return self

    def peaks(self) -> tuple[PeakRequest, ...]:
        if self.mode is None or self.force is None:
            return ()
        return (PeakRequest(self.mode, self.force, "", self.by),)

    def modes(self) -> tuple[str, ...]:
        return () if self.mode is None else (self.mode,)

    def value(self, design: SolvedDesign) -> float:
        force = _at_rest(design.model)
        for request in self.peaks():
            peak = design.peak(request)
            force = force + _largest_change(design.model, peak.displacement, 2 * np.pi * peak.frequency)
        return 1e-6 * float(np.max(force / _areas(design.model)))


def _at_rest(model: RigModel) -> NDArray[np.float64]:
    """(n,) normal force of each contact element [N]"""
    assert model.contacts is not None, "asked for where there are contacts only"
    p = model.contacts.parameters
    return np.maximum(np.asarray(p.n0) - np.asarray(p.kn) * np.asarray(p.gap), 0.0)


def _largest_change(model: RigModel, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
    """(n,) largest rise of the normal force over a period [N]; the laws give the force less that at rest."""
    group = model.contacts
    assert group is not None, "asked for where there are contacts only"
    _, force = over_period(group, group.law.force, x[group.rows], w, model.harmonics, _SAMPLES)
    return np.asarray(force[..., 2].max(axis=1))


def _areas(model: RigModel) -> NDArray[np.float64]:
    """(n,) of the contact elements [m^2]"""
    assert model.patches is not None, "a rig with geometry has contact patches"
    return model.patches.area
