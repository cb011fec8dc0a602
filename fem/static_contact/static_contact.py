"""The static contact stage: the rest state of every contact element under the pull."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.finite_element_pressure import finite_element
from updamp.fem.static_contact.prescribed_pressure import polynomial, two_area, uniform
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.rig.pressure import FePressure, PolynomialPressure, TwoAreaPressure, UniformPressure
from updamp.rig.rig import Rig

PressureModel = Callable[[ReducedModel, Rig], StaticContact]

PRESSURE_MODELS: Mapping[type, PressureModel] = MappingProxyType(
    {
        UniformPressure: uniform,
        TwoAreaPressure: two_area,
        PolynomialPressure: polynomial,
        FePressure: finite_element,
    }
)


def static_contact(reduced: ReducedModel, rig: Rig) -> StaticContact:
    """Rest state under rig.load.pull, by the pressure model that rig.contact.pressure chooses.

    Normal forces press (positive). Tangential forces are positive where they oppose a damper that has moved along
    +t1 (up the slope) or +t2 (+z) against the platform: they act on the damper as -T t, on the platform as +T t.
    The prescribed models need only the contact elements of the reduced model, "fe" its flexibility too.

    raises: ValueError if a prescribed pressure carries no load; StaticContactError if "fe" is not solved
    """
    return PRESSURE_MODELS[type(rig.contact.pressure)](reduced, rig)
