"""Springs between the components' interfaces: stuck contact and the pulling wires."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.interface import BLADE_POINTS, DAMPER_POINTS
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Springs:
    """Forces - directions stiffness directions^T y on the interface displacements y of all three components.

    Rows: interface degrees of freedom of the left blade, the right blade, the damper, as in ReducedModel.

    directions: (n_rows, n_springs); stiffness: (n_springs,) [N/m]
    """

    directions: Floats
    stiffness: Floats

    def __add__(self, other: "Springs") -> "Springs":
        return Springs(
            np.hstack([self.directions, other.directions]), np.concatenate([self.stiffness, other.stiffness])
        )


@dataclass(frozen=True)
class ContactStiffness:
    """Per area, tangential and normal [N/m^3]."""

    tangential: float
    normal: float

    def __post_init__(self) -> None:
        for name, value in (("tangential", self.tangential), ("normal", self.normal)):
            if not value > 0:
                raise ValueError(f"contact.{name}_stiffness = {value} N/m^3 must be positive")


@dataclass(frozen=True)
class Wires:
    """Both pulling wires. axial_stiffness [N/m] and pull [N] of both together; length [m]; attachment_height [m]
    above the damper's centroid; half_width [m], half the distance between the damper's bottom corners."""

    axial_stiffness: float
    pull: float
    length: float
    attachment_height: float
    half_width: float


def interface_sizes(contacts: ContactElements) -> tuple[int, int, int]:
    """Interface degrees of freedom of the left blade, the right blade and the damper."""
    left, right = ((contacts.face == side).sum() for side in (LEFT, RIGHT))
    return (
        3 * int(left) + len(BLADE_POINTS),
        3 * int(right) + len(BLADE_POINTS),
        3 * len(contacts) + len(DAMPER_POINTS),
    )


def stuck_contact(contacts: ContactElements, stiffness: ContactStiffness) -> Springs:
    """Every contact element stuck and closed: damper minus platform in each local direction."""
    sizes = interface_sizes(contacts)
    rows = np.arange(3 * len(contacts)).reshape(-1, 3)
    directions = np.zeros((sum(sizes), rows.size))
    for side, start in ((LEFT, 0), (RIGHT, sizes[0])):
        columns = rows[contacts.face == side].ravel()
        directions[start + np.arange(len(columns)), columns] = -1
    directions[sizes[0] + sizes[1] + np.arange(rows.size), np.arange(rows.size)] = 1
    per_area = np.array([stiffness.tangential, stiffness.tangential, stiffness.normal])
    return Springs(directions, (contacts.area[:, None] * per_area).ravel())


def wire_springs(contacts: ContactElements, wires: Wires) -> Springs:
    """Axial stiffness upwards, tension over length sideways, and the restoring roll moment of a pull that acts above
    the centroid, where it does (a spring of no stiffness is left out)."""
    sideways, upwards = wires.pull / 2 / wires.length, wires.axial_stiffness / 2
    rows, values = [], []
    for end in ("back", "front"):
        for axis, stiffness in (("x", sideways), ("y", upwards), ("z", sideways)):
            rows.append(damper_point(contacts, f"wire_{end}.{axis}"))
            values.append(stiffness)
    if wires.attachment_height:
        roll = damper_point(contacts, "corner_right.y") - damper_point(contacts, "corner_left.y")
        rows.append(roll / (2 * wires.half_width))
        values.append(wires.pull * wires.attachment_height)
    return Springs(np.stack(rows, axis=1), np.array(values))


def damper_point(contacts: ContactElements, point: str) -> Floats:
    """(n_rows,) one at a named point of the damper."""
    sizes = interface_sizes(contacts)
    return np.eye(1, sum(sizes), sum(sizes) - len(DAMPER_POINTS) + DAMPER_POINTS.index(point))[0]
