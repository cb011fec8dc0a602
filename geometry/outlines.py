"""Outlines of the cross sections and the areas inside: for pictures, and for masses without a mesh."""

import numpy as np
from numpy.typing import NDArray

from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def damper_outline(rig: Rig) -> Floats:
    """(n, 2) x and y of the damper's corners, up its right-hand side and down its left one [m]."""
    damper, (wide, low), (narrow, high) = rig.damper, rig.face_bottom, rig.face_top
    right = [(wide, low - damper.base_height), (wide, low), (narrow, high)]
    if damper.apex_height > 0:
        right.append((damper.apex_flat / 2, high + damper.apex_height))
    corners = np.array(right)
    return np.vstack([corners, (corners * [-1.0, 1.0])[::-1]])


def blade_outline(rig: Rig) -> Floats:
    """(n, 2) x and y of the right-hand blade's corners, stem and platform [m]."""
    middle, half = rig.blade.axis_offset, rig.blade.thickness / 2
    inner, outer, gap = middle - half, middle + half, rig.platform.gap / 2
    return np.array(
        [
            (inner, 0.0), (outer, 0.0), (outer, rig.blade.height), (inner, rig.blade.height), (inner, rig.platform.top),
            (gap, rig.platform.top), (gap, rig.edge_height), (inner, rig.junction_height),
        ]
    )  # fmt: skip


def area(outline: Floats) -> float:
    """Inside a polygon that does not cross itself, by its corners (n, 2) [m^2]."""
    x, y = outline.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
