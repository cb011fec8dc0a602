"""A central strip of each face carries its own share of the load (Pesaresi et al. 2017, section 4: 70/30 to 100/0)."""

import numpy as np
from numpy.typing import NDArray
from shapely import area, box, intersection, polygons

from updamp.fem.contact_face import FaceCoordinates, prescribed_rest
from updamp.fem.contact_rest import StaticContact
from updamp.fem.reduced_model import ReducedModel
from updamp.rig import Rig
from updamp.rig_pressure import TwoAreaPressure

Floats = NDArray[np.float64]


def two_area(reduced: ReducedModel, rig: Rig) -> StaticContact:
    """Pressure constant in the central strip and constant outside it; the strip spans the whole face up the slope.

    A patch across the border gets the area-weighted mean, by exact clipping, so the shares hold exactly on any mesh.
    """
    options = rig.contact.pressure
    assert isinstance(options, TwoAreaPressure)
    inside = central_part(FaceCoordinates.of(reduced.contacts), options.central_fraction)
    share, fraction = options.central_share, options.central_fraction
    pressure = inside * share / fraction + (1 - inside) * (1 - share) / (1 - fraction)
    return prescribed_rest(reduced.contacts, pressure, rig)


def central_part(coordinates: FaceCoordinates, fraction: float) -> Floats:
    """(n,) part of each patch's area that lies in the central strip of this fraction of the damper's length."""
    patches = polygons(np.stack([coordinates.slope, coordinates.along], axis=-1))
    half = fraction * coordinates.width / 2
    strips = box(-coordinates.length, -half, coordinates.length, half)
    return area(intersection(patches, strips)) / area(patches)
