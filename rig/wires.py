"""The pulling wires as springs on the damper: the one table that the finite elements and the nonlinear model read."""

from collections.abc import Mapping
from dataclasses import dataclass

from updamp.rig.rig import Rig

AXIAL = ("wire_back.y", "wire_front.y")


@dataclass(frozen=True)
class WireSpring:
    """A spring on the sum of the damper's displacements there, each times its factor.

    points: point of the damper, such as "wire_back.y" -> factor; stiffness [N/m, for the roll N m]
    by_pull: whether the stiffness comes from the pull, and is proportional to it
    """

    name: str
    points: Mapping[str, float]
    stiffness: float
    by_pull: bool


def wire_springs(rig: Rig) -> tuple[WireSpring, ...]:
    """Both wires: axial stiffness upwards, tension over length sideways, and the restoring roll moment of a pull that
    acts above the centroid.

    The damper has no other support once all contacts are open, so the zero harmonic needs all of them.
    """
    wire, sideways = rig.wire, rig.load.pull / 2 / rig.wire.length
    along = {"x": (sideways, True), "y": (wire.axial_stiffness / 2, False), "z": (sideways, True)}
    springs = [
        WireSpring(f"wire_{end}.{axis}", {f"wire_{end}.{axis}": 1.0}, stiffness, by_pull)
        for end in ("back", "front")
        for axis, (stiffness, by_pull) in along.items()
    ]
    lever = 1 / (2 * rig.face_bottom[0])
    roll = {"corner_right.y": lever, "corner_left.y": -lever}
    return (*springs, WireSpring("wire roll", roll, rig.load.pull * wire.attachment_height, by_pull=True))
