"""Deviation of the damper's faces from planes, as the initial gap of the contact patches."""

import numpy as np
from numpy.typing import NDArray

from updamp.fem.contact_face import FaceCoordinates, patch_average
from updamp.rig_pressure import SurfaceProfile

Floats = NDArray[np.float64]


def initial_gap(coordinates: FaceCoordinates, profile: SurfaceProfile) -> Floats:
    """(n,) patch averages of the gap [m], the same on both faces; 0 everywhere for plane faces.

    crown:         min(s^2 / (2 R), height), s from the middle of the face up its slope
    tilt:          tan(tilt) times the distance from the end of the damper that stands out; a damper that floats
                   turns until such faces fit, so that the tilt acts only through the path of friction
    edge_rounding: (r - d)^2 / (2 r) within the distance d < r of the upper and of the lower edge
    """
    half_length, half_width = coordinates.length[:, None] / 2, coordinates.width[:, None] / 2
    crown = profile.crown(float(coordinates.length.max()))
    radius = profile.edge_rounding

    def gap(s: Floats, z: Floats) -> Floats:
        opening = np.tan(profile.tilt) * z + abs(np.tan(profile.tilt)) * half_width
        if crown is not None:
            opening = opening + np.minimum(s**2 / (2 * crown[1]), crown[0])
        if radius > 0:
            opening = opening + np.maximum(radius - (half_length - np.abs(s)), 0.0) ** 2 / (2 * radius)
        return opening

    return patch_average(coordinates, gap)
