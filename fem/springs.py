"""Springs between the components' interfaces: stuck contact and the pulling wires."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.interface import BLADE_POINTS, DAMPER_POINTS
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.rig.wires import WireSpring

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


def on_damper(contacts: ContactElements, wires: Sequence[WireSpring]) -> Springs:
    """The wires; a spring of no stiffness is left out."""
    acting = [spring for spring in wires if spring.stiffness]
    rows = [
        sum((factor * damper_point(contacts, point) for point, factor in spring.points.items()), start=np.zeros(1))
        for spring in acting
    ]
    return Springs(np.stack(rows, axis=1), np.array([spring.stiffness for spring in acting]))


def damper_point(contacts: ContactElements, point: str) -> Floats:
    """(n_rows,) one at a named point of the damper."""
    sizes = interface_sizes(contacts)
    return np.eye(1, sum(sizes), sum(sizes) - len(DAMPER_POINTS) + DAMPER_POINTS.index(point))[0]
