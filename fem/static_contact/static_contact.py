"""The static contact stage: the rest state of every contact element under the pull.

`PRESSURE_MODELS` are the models that a rig file can name. Three state the pressure's shape (`SHAPES`), after Pesaresi
et al. 2017: a 4th-order polynomial, given or fitted to the scan of a pressure film (section 2); a central strip of each
face that carries its own share of the load (section 4: 70/30 to 100/0); the same pressure everywhere (eq. 5). One takes
such a shape for each face (section 4: one uniform, the other 90/10). The last finds the pressure from unilateral
contact (fem/static_contact/finite_element_pressure.py).
"""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.polynomial.polynomial import polyval2d, polyvander2d
from numpy.typing import NDArray
from shapely import area, box, intersection, polygons

from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.finite_element_pressure import finite_element
from updamp.fem.static_contact.rest_state import FaceCoordinates, StaticContact, patch_average, prescribed_rest
from updamp.geometry.contact_elements import LEFT, ContactElements
from updamp.rig.pressure import (
    ORDER,
    ByFacePressure,
    FePressure,
    PolynomialPressure,
    StatedPressure,
    TwoAreaPressure,
    UniformPressure,
)
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]
PressureModel = Callable[[ReducedModel, Rig], StaticContact]


def polynomial(contacts: ContactElements, options: StatedPressure) -> Floats:
    """Average of max(p, 0) over each patch; (s, z) run from -1 to 1 over the face.

    s points up the slope and z along the damper on both faces: they are mirror images.
    raises: ValueError if a scan does not determine the polynomial
    """
    assert isinstance(options, PolynomialPressure)
    coefficients = np.asarray(options.coefficients) if options.map is None else fit_polynomial(options.map)
    coordinates = FaceCoordinates.of(contacts)
    half_length, half_width = coordinates.length[:, None] / 2, coordinates.width[:, None] / 2

    def pressure(s: Floats, z: Floats) -> Floats:
        return np.maximum(polyval2d(s / half_length, z / half_width, coefficients), 0.0)

    return patch_average(coordinates, pressure)


def fit_polynomial(samples: Sequence[tuple[float, float, float]]) -> Floats:
    """(5, 5) coefficients c[i, j] of s^i z^j, i + j <= 4, by least squares.

    samples: (s, z, pressure), s and z from -1 to 1
    raises: ValueError if the samples lie so that they do not determine all 15 coefficients
    """
    s, z, pressure = np.asarray(samples, dtype=float).T
    powers = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
    columns = polyvander2d(s, z, [ORDER, ORDER])[:, [i * (ORDER + 1) + j for i, j in powers]]
    fitted, _, rank, _ = np.linalg.lstsq(columns, pressure, rcond=1e-10)
    if rank < len(powers):
        raise ValueError(
            f"contact.pressure.map: the {len(s)} samples determine only {rank} of the {len(powers)} coefficients of a "
            f"4th-order polynomial; spread them over the face, at least 5 different values each of s and of z"
        )
    coefficients = np.zeros((ORDER + 1, ORDER + 1))
    for (i, j), value in zip(powers, fitted, strict=True):
        coefficients[i, j] = value
    return coefficients


def two_area(contacts: ContactElements, options: StatedPressure) -> Floats:
    """Pressure constant in the central strip and constant outside it; the strip spans the whole face up the slope.

    A patch across the border gets the area-weighted mean, by exact clipping, so the shares hold exactly on any mesh.
    """
    assert isinstance(options, TwoAreaPressure)
    inside = central_part(FaceCoordinates.of(contacts), options.central_fraction)
    share, fraction = options.central_share, options.central_fraction
    return inside * share / fraction + (1 - inside) * (1 - share) / (1 - fraction)


def central_part(coordinates: FaceCoordinates, fraction: float) -> Floats:
    """(n,) part of each patch's area that lies in the central strip of this fraction of the damper's length."""
    patches = polygons(np.stack([coordinates.slope, coordinates.along], axis=-1))
    half = fraction * coordinates.width / 2
    strips = box(-coordinates.length, -half, coordinates.length, half)
    return area(intersection(patches, strips)) / area(patches)


def uniform(contacts: ContactElements, options: StatedPressure) -> Floats:  # noqa: ARG001
    """The same pressure everywhere, sigma0 = CF / (2 A (cos(alpha) + mu sin(alpha))); N0 its integral over a patch."""
    return np.ones(len(contacts))


SHAPES: Mapping[type, Callable[[ContactElements, StatedPressure], Floats]] = MappingProxyType(
    {UniformPressure: uniform, TwoAreaPressure: two_area, PolynomialPressure: polynomial}
)
"""(n,) average pressure over each patch, at least 0, in any unit: each face is scaled to its load afterwards."""


def stated(reduced: ReducedModel, rig: Rig) -> StaticContact:
    """The same shape on both faces."""
    options = rig.contact.pressure
    assert isinstance(options, StatedPressure)
    return prescribed_rest(reduced.contacts, SHAPES[type(options)](reduced.contacts, options), rig)


def by_face(reduced: ReducedModel, rig: Rig) -> StaticContact:
    """A shape for each face."""
    options, contacts = rig.contact.pressure, reduced.contacts
    assert isinstance(options, ByFacePressure)
    left, right = (SHAPES[type(one)](contacts, one) for one in (options.left, options.right))
    return prescribed_rest(contacts, np.where(contacts.face == LEFT, left, right), rig)


PRESSURE_MODELS: Mapping[type, PressureModel] = MappingProxyType(
    {
        UniformPressure: stated,
        TwoAreaPressure: stated,
        PolynomialPressure: stated,
        ByFacePressure: by_face,
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
