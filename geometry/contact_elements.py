"""The contact elements: triangular patches laid over the damper's two contact faces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.geometry.points_of_force import barycentric

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

LEFT, RIGHT = 0, 1


@dataclass(frozen=True, eq=False)
class ContactElements:
    """One entry a contact element, those of the left face first, then those of the right in the same order.

    Local axes (t1, t2, n): t1 points up the slope of the face, t2 along +z, n from the damper into the
    platform. The left face is the mirror image (x -> -x) of the right one and so are its axes; they are
    therefore left-handed there, and mirror-symmetric motion has equal coordinates on both faces.

    face: (n,) LEFT or RIGHT
    point: (n, 3) where the element's force acts [m], in its triangle (geometry/points_of_force.py)
    area: (n,) [m^2]
    tangent1, tangent2, normal: (n, 3) unit vectors
    triangle: (n, 3, 3) the patch's corners [m]
    """

    face: Integers
    point: Floats
    area: Floats
    tangent1: Floats
    tangent2: Floats
    normal: Floats
    triangle: Floats

    def __len__(self) -> int:
        return len(self.area)

    @property
    def axes(self) -> Floats:
        """(n, 3, 3): axes[i, d] is the unit vector of local direction d (t1, t2, n) of element i."""
        return np.stack([self.tangent1, self.tangent2, self.normal], axis=1)

    @property
    def corner_weights(self) -> Floats:
        """(n, 3) values at the corners of the linear function over each triangle whose mean is one and whose first
        moment is that of the point: a force of 1 at the point is a traction of this over the area.

        The mean of l_i l_j over a triangle, l its barycentric coordinates, is (1 + d_ij) / 12, so the function with the
        values w has its moment at the coordinates (3 + w) / 12 where the w have the sum 3.
        """
        return 12 * barycentric(self.triangle, self.point) - 3


# Of the width: mirrored points this close are the same.
SAME_PLACE = 1e-6


def across_mid_width(patches: ContactElements) -> tuple[Integers, Floats] | None:
    """For each element the number of its mirror image at the other side of mid-width (n,), and the sign that each of
    its local displacements takes in the image (n, 3); None where the elements are not laid out evenly.
    """
    reflection = np.array([1.0, 1.0, -1.0])
    z = patches.point[:, 2]
    mirrored = patches.point * reflection + np.array([0.0, 0.0, z.min() + z.max()])
    apart = np.linalg.norm(mirrored[:, None] - patches.point, axis=2)
    image = apart.argmin(axis=1)
    sign = np.einsum("ndx,ndx->nd", patches.axes * reflection, patches.axes[image])
    far = apart.min(axis=1).max() > SAME_PLACE * max(float(np.ptp(z)), np.finfo(float).tiny)
    if far or not np.allclose(np.abs(sign), 1.0, atol=SAME_PLACE) or (image[image] != np.arange(len(image))).any():
        return None
    return image, np.round(sign)
