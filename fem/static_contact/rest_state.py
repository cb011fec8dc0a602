"""What the static contact stage hands on: the rest state of every contact element.

With what its models share: coordinates on the contact faces, averages over their patches, the load that one face
carries, and the rest state of a prescribed pressure.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StaticContact:
    """Rest state under the pull, one entry a contact element.

    normal_force: (n,) N0 >= 0, pressing [N]
    tangential_force: (n, 2) force of the platform on the damper's motion along (t1, t2) at rest, T0 [N]
    gap: (n,) opening at rest where there is no contact, else 0 [m]
    applied: pull on the damper [N]
    normal_total: sum of normal_force over both faces [N]
    equilibrium_error: |vertical resultant of the contacts - applied| / applied
    """

    model: str
    normal_force: Floats
    tangential_force: Floats
    gap: Floats
    applied: float
    normal_total: float
    equilibrium_error: float


SUBDIVISIONS = 4  # of a patch's edges: the integrands are clipped, so one high-order rule would not do


@dataclass(frozen=True, eq=False)
class FaceCoordinates:
    """Corners of the patches in their face's own plane, from its middle; every face has its own middle.

    slope: (n, 3) coordinate s up the slope, along t1 [m]; along: (n, 3) coordinate z along the damper [m]
    length, width: (n,) extent of the patch's face along s and z [m]
    """

    slope: Floats
    along: Floats
    length: Floats
    width: Floats

    @classmethod
    def of(cls, contacts: ContactElements) -> "FaceCoordinates":
        """raises: ValueError if a face has no contact element."""
        n = len(contacts)
        slope = np.einsum("ncx,nx->nc", contacts.triangle, contacts.tangent1)
        along = np.einsum("ncx,nx->nc", contacts.triangle, contacts.tangent2)
        length, width = np.empty(n), np.empty(n)
        for side, name in ((LEFT, "left"), (RIGHT, "right")):
            on = contacts.face == side
            if not np.any(on):
                raise ValueError(f"the {name} face has no contact element; both faces must carry the damper")
            for coordinate, extent in ((slope, length), (along, width)):
                low, high = coordinate[on].min(), coordinate[on].max()
                extent[on] = high - low
                coordinate[on] -= (low + high) / 2
        return cls(slope, along, length, width)


def patch_average(coordinates: FaceCoordinates, value: Callable[[Floats, Floats], Floats]) -> Floats:
    """(n,) average over every patch of value(s, z), which gets and returns arrays (n, n_points). [s, z: m]

    Exact for polynomials up to order 4; other functions are sampled at 96 points a patch.
    """
    points, weights = _subdivided_rule()
    return value(coordinates.slope @ points, coordinates.along @ points) @ weights


def _subdivided_rule() -> tuple[Floats, Floats]:
    """Barycentric points (3, n_points) and weights that sum to 1, of the rule of order 4 on every sub-triangle."""
    local, weight = get_quadrature(RefTri, 4)
    k = SUBDIVISIONS
    offsets = np.array([(i, j) for i in range(k) for j in range(k - i)])
    upright = (offsets[:, :, None] + local[None]) / k
    corner = offsets[offsets.sum(axis=1) < k - 1]
    inverted = (corner[:, :, None] + 1 - local[None]) / k
    xy = np.concatenate([upright, inverted]).transpose(1, 0, 2).reshape(2, -1)
    return np.vstack([1 - xy.sum(axis=0), xy]), np.tile(2 * weight / k**2, k**2)


def face_normal_force(rig: Rig) -> float:
    """Normal force of one face under the pull, friction fully used [N]: sigma0 A of eq. (5), Pesaresi et al. 2017."""
    alpha, mu = rig.platform.underside_angle, rig.contact.friction_coefficient
    return float(rig.load.pull / (2 * (np.cos(alpha) + mu * np.sin(alpha))))


def prescribed_rest(contacts: ContactElements, relative_pressure: Floats, rig: Rig) -> StaticContact:
    """Rest state of a prescribed shape of the pressure, each face scaled to the load of eq. (5).

    Friction is fully used along the slope: T0 = +mu N0 in t1 on both faces. In the sign of the contact forces,
    which act on the damper as -N n - T1 t1 - T2 t2, this holds the damper back against the pull: its vertical
    part is mu N0 sin(alpha) downwards.

    relative_pressure: (n,) average over each patch, at least 0, in any unit
    raises: ValueError if a face carries nothing
    """
    normal = relative_pressure * contacts.area
    for side, name in ((LEFT, "left"), (RIGHT, "right")):
        on = contacts.face == side
        if not normal[on].sum() > 0:
            raise ValueError(
                f"contact.pressure: the {name} face would carry no load; the mean pressure must be above 0"
            )
        normal[on] *= face_normal_force(rig) / normal[on].sum()
    tangential = np.column_stack([rig.contact.friction_coefficient * normal, np.zeros(len(contacts))])
    return rest_state(rig.contact.pressure.model, contacts, normal, tangential, np.zeros(len(contacts)), rig.load.pull)


def rest_state(
    model: str, contacts: ContactElements, normal: Floats, tangential: Floats, gap: Floats, applied: float
) -> StaticContact:
    """The stage's result, with the vertical resultant taken from the contact elements' own axes."""
    local = np.column_stack([tangential, normal])
    vertical = float(np.einsum("nd,nd->", local, contacts.axes[:, :, 1]))
    return StaticContact(
        model=model,
        normal_force=normal,
        tangential_force=tangential,
        gap=gap,
        applied=applied,
        normal_total=float(normal.sum()),
        equilibrium_error=abs(vertical - applied) / applied,
    )
